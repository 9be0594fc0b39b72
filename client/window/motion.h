#pragma once

#include <chrono>
#include <optional>

#include "client/playback/stage.h"
#include "client/render/draft.h"
#include "client/scene/draw_options.h"

namespace pointreel {

/// Knows what moves in a window, and so how long there is to draw a picture.
class WindowMotion {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  void move_camera(TimePoint now) { moved_ = now; }
  void show_frame(TimePoint now) { shown_ = now; }
  /// Keys that fly the camera are held, or not.
  void set_flying(bool flying) { flying_ = flying; }
  bool flying() const { return flying_; }

  /// For the next picture. `by_hand`: the user drags the time, or waits for the first picture.
  Haste haste(Drafts drafts, const Stage& stage, bool by_hand, TimePoint now) const;

  /// When there may be more time for a picture, because something has come to rest by then.
  std::optional<TimePoint> next_rest(TimePoint now) const;

 private:
  TimePoint moved_{}, shown_{};
  bool flying_ = false;
};

}  // namespace pointreel
