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

/// A test that uses the player as a user does. It is skipped if Xvfb or xdotool is not installed.
/// If POINTREEL_WINDOW_PICTURES=FOLDER is set in the environment, the pictures that tests name are
/// kept in that folder.
class WindowTest : public testing::Test {
 protected:
  void SetUp() override;

  /// Opens `pointreel play REEL ARGUMENTS...`.
  void open(std::vector<std::string> arguments = {});
  /// The same with these sources.
  void open_sources(std::vector<std::string> arguments);

  PlayerWindow& player() { return *player_; }
  const MovingPlate& plate() const { return Stand::get().plate; }
  VirtualDisplay& display() const { return *Stand::get().display; }

  /// The visible frame, or -1 if there is none.
  int frame() const;
  bool wait_for_frame(int number) const;
  /// Waits until the same frame has been visible for a while. Returns -1 if that does not happen.
  int paused_frame() const;
  bool wait_for_next_frame() const;
  void pause();

  /// Keeps the picture under this name if pictures are wanted.
  void keep(const std::string& name) const;

  /// Ends the player with "q" and expects that it exits without complaint.
  nlohmann::json quit();

  TemporaryFolder folder_;
  std::unique_ptr<PlayerWindow> player_;
};

}  // namespace pointreel::window
