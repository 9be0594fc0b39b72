#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pointreel/error.h"
#include "tests/bench/stream/chapter.h"
#include "tests/window/player_window.h"
#include "tests/window/virtual_display.h"

namespace pointreel::bench {

/// The player with a display of its own.
struct WatchedWindow {
  std::unique_ptr<window::VirtualDisplay> display;
  std::unique_ptr<window::PlayerWindow> player;

  static Result<WatchedWindow> open(const StreamOptions& options,
                                    const std::vector<std::string>& arguments);

  /// Until something that is not the background is in the middle of the window.
  bool wait_for_picture() const;
  /// Until the picture has not changed for a second and a half.
  void wait_until_settled() const;
  /// Until the window shows this frame of a package as it is drawn without a window, but for at
  /// most ten seconds: the share of pixels that then differ by more than rounding, of those that
  /// the interface does not write on by itself.
  Result<double> differing_share(const std::string& reel, double at,
                                 const StreamOptions& options) const;
  /// What the player tells once it has ended by itself.
  Result<nlohmann::json> quit();
};

}  // namespace pointreel::bench
