#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pointreel/error.h"
#include "tests/bench/stream/chapter.h"
#include "tests/window/player_window.h"
#include "tests/window/virtual_display.h"

namespace pointreel::bench {

/// The player in a window on a virtual display of its own.
struct WatchedWindow {
  std::unique_ptr<window::VirtualDisplay> display;
  std::unique_ptr<window::PlayerWindow> player;

  static Result<WatchedWindow> open(const StreamOptions& options,
                                    const std::vector<std::string>& arguments);

  /// Waits until the middle of the window shows more than the background. Returns false if that
  /// takes too long.
  bool wait_for_picture() const;
  /// Waits until the picture has not changed for a second and a half.
  void wait_until_settled() const;
  /// Waits for at most ten seconds until the window shows the frame at the time `at` (in seconds)
  /// of a package exactly as it is drawn without a window. Returns the share of the pixels that
  /// then differ by more than rounding. Pixels on which the interface writes by itself do not
  /// count.
  Result<double> differing_share(const std::string& reel, double at,
                                 const StreamOptions& options) const;
  /// Ends the player as a user does, and returns its report.
  Result<nlohmann::json> quit();
};

}  // namespace pointreel::bench
