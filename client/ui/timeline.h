#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "client/playback/clock.h"
#include "client/ui/bindings.h"

namespace pointreel {

/// What the bar at the bottom of the window tells.
struct TimelineView {
  bool live = false;  ///< no reel: there is no time to go to
  bool playing = false;
  bool help_shown = false, drawing_shown = false, statistics_shown = false;

  // Of a reel.
  const Timeline* timeline = nullptr;  ///< which outlives the view

  /// Frames [first, last) of which a share of what is wanted is there, 0 to 1.
  struct Buffered {
    std::uint64_t begin_us = 0, end_us = 0;
    float share = 0.0f;
  };
  std::uint64_t duration_us = 1, position_us = 0;
  std::uint32_t frame = 0, frames = 1;
  std::vector<Buffered> buffered;
  std::optional<std::uint64_t> loop_a_us, loop_b_us;
  bool loop = false, waiting = false;
  double speed = 1.0;
};

/// A picture for the time that the cursor is at; an OpenGL texture, its first row at the bottom.
struct Thumbnail {
  unsigned texture = 0;
  glm::ivec2 size{0};
};

/// What the user does to the bar.
struct TimelineUse {
  std::optional<std::uint64_t> hovered_us;  ///< the time that the cursor is at
  std::optional<Action> action;             ///< of the button that was pressed
};

inline constexpr const char* kTimelineWindow = "timeline";  ///< its name in the gui
/// Height of the bar, in pixels at scale 1.
inline constexpr float kTimelineHeight = 70.0f;

/// Of the part of the bar that the time can be dragged on; window coordinates.
struct TrackArea {
  float left = 0.0f, right = 1.0f, top = 0.0f, bottom = 1.0f;
};
TrackArea track_area(glm::vec2 size, float scale);

/// The bar across the bottom of a window of `size`; between Gui::begin and end. `opacity` 0 to 1.
/// `dragged`: the time is; `thumbnail` of the time that was hovered the last time, if there is one
/// by now.
TimelineUse draw_timeline(const TimelineView& view, const std::optional<Thumbnail>& thumbnail,
                          bool dragged, glm::vec2 size, float scale, float opacity);

}  // namespace pointreel
