#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "client/playback/clock.h"
#include "client/ui/bindings.h"

namespace pointreel {

/// What the bar at the bottom of the window shows.
struct TimelineView {
  bool live = false;  ///< there are only live streams, which have no other time to go to
  bool playing = false;
  bool help_shown = false, drawing_shown = false, statistics_shown = false;

  // Only for a reel.
  const Timeline* timeline = nullptr;  ///< must outlive the view

  /// A time span of which frames have been fetched, and with what share of their layers, 0 to 1.
  struct Buffered {
    std::uint64_t begin_us = 0, end_us = 0;
    float share = 0.0f;
  };
  std::uint64_t duration_us = 1, position_us = 0;
  std::uint32_t frame = 1, frames = 1;  ///< of those that are shown
  std::vector<Buffered> buffered;
  std::optional<std::uint64_t> loop_a_us, loop_b_us;
  bool loop = false, waiting = false;
  double speed = 1.0;
};

/// A small picture of the time under the cursor: an OpenGL texture, whose first row is the lowest.
struct Thumbnail {
  unsigned texture = 0;
  glm::ivec2 size{0};
};

/// What the user does with the bar.
struct TimelineUse {
  std::optional<std::uint64_t> hovered_us;  ///< the time under the cursor
  std::optional<Action> action;             ///< of the button that was pressed
};

inline constexpr const char* kTimelineWindow = "timeline";  ///< name of the ImGui window
/// Height of the bar, in pixels at scale 1.
inline constexpr float kTimelineHeight = 70.0f;

/// The part of the bar on which the time can be dragged, in window coordinates.
struct TrackArea {
  float left = 0.0f, right = 1.0f, top = 0.0f, bottom = 1.0f;
};
TrackArea track_area(glm::vec2 size, float scale);

/// Draws the bar across the bottom of a window of `size`, with an `opacity` from 0 to 1. To be
/// called between Gui::begin and end. `thumbnail` shows the time that was under the cursor in the
/// last call; `dragged` says whether the user is dragging the time.
TimelineUse draw_timeline(const TimelineView& view, const std::optional<Thumbnail>& thumbnail,
                          bool dragged, glm::vec2 size, float scale, float opacity);

}  // namespace pointreel
