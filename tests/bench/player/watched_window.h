#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/base/error.h"
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
  /// Until the picture has not changed for a second and a half; without_texts of it.
  e2e::Picture settled() const;
  /// What the player tells once it has ended by itself.
  Result<nlohmann::json> quit();
};

/// The rows in which the interface writes nothing by itself: of what a window shows, or of what is
/// drawn without one.
e2e::Picture without_texts(const e2e::Picture& picture);

/// Share of pixels that differ by more than rounding, of this frame drawn without a window.
Result<double> differing_share(const e2e::Picture& shown, const std::string& reel, double at,
                               glm::ivec2 size, const StreamOptions& options);

}  // namespace pointreel::bench
