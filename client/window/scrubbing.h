#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "client/playback/statistics.h"
#include "client/scene/frame.h"
#include "client/ui/controls.h"
#include "client/ui/window_input.h"

namespace pointreel {

/// Drags the time, and measures how soon the window shows the frames that are asked for.
class Scrubbing {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// Moves the time as `input` says. `shown` is the frame in the window; null: none.
  void drag(const Input& input, Controls& controls, const SceneFrame* shown, TimePoint now);
  /// The window shows this frame now; null: none.
  void show(const SceneFrame* shown, TimePoint now);
  /// Something else plays.
  void forget() { asked_.reset(); }

  /// Until when the interface waits for the frame that is asked for, to be drawn together with it.
  /// In the past if it waits for none.
  TimePoint awaited_until() const;

  /// From the first move that asks for another frame until the window shows it.
  const TimeSamples& times() const { return times_; }

 private:
  std::optional<TimePoint> asked_;  ///< for a frame that is not shown yet
  std::uint32_t frame_ = 0;         ///< the one under the cursor
  TimeSamples times_;
};

}  // namespace pointreel
