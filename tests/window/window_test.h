#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/temporary_folder.h"
#include "tests/window/moving_plate.h"
#include "tests/window/player_window.h"
#include "tests/window/virtual_display.h"

namespace pointreel::window {

/// The display and the reel, which all tests of a process share.
struct Stand {
  static Stand& get();

  std::unique_ptr<VirtualDisplay> display;
  MovingPlate plate;
  TemporaryFolder folder;
};

/// Somebody uses the player. Skipped where Xvfb or xdotool are not installed. With
/// POINTREEL_WINDOW_PICTURES=FOLDER in the environment, the pictures that tests name are kept
/// there.
class WindowTest : public testing::Test {
 protected:
  void SetUp() override;

  /// `pointreel play REEL ARGUMENTS...`.
  void open(std::vector<std::string> arguments = {});
  /// The same with these sources.
  void open_sources(std::vector<std::string> arguments);

  PlayerWindow& player() { return *player_; }
  const MovingPlate& plate() const { return Stand::get().plate; }
  VirtualDisplay& display() const { return *Stand::get().display; }

  /// Which frame is to be seen; -1 where there is none.
  int frame() const;
  bool wait_for_frame(int number) const;
  /// Until the same frame has been to be seen for a while; -1 if it does not come to that.
  int paused_frame() const;
  bool wait_for_next_frame() const;
  void pause();

  /// Keeps the picture, if that is wanted.
  void keep(const std::string& name) const;

  /// Ends it by "q": without complaint, and by itself.
  nlohmann::json quit();

  TemporaryFolder folder_;
  std::unique_ptr<PlayerWindow> player_;
};

}  // namespace pointreel::window
