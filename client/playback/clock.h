#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "client/playback/play_order.h"

namespace pointreel {

/// When each frame of a reel begins, in microseconds from the reel's start, not decreasing, and how
/// long one pass takes. At least one frame; duration_us > 0.
struct Timeline {
  std::vector<std::uint64_t> times_us;
  std::uint64_t duration_us = 0;
  std::vector<std::uint32_t> shown = {};  ///< the frames that are ever shown; empty if all are

  std::uint32_t frame_count() const { return static_cast<std::uint32_t>(times_us.size()); }
  /// The last frame that begins at or before `time_us`; the first if there is none.
  std::uint32_t frame_at(std::uint64_t time_us) const;
  /// Which of the frames that are shown that of a time is, from 1 on; and how many they are.
  std::uint32_t shown_number(std::uint64_t time_us) const;
  std::uint32_t shown_count() const;
};

/// A part that is played again and again: from a_us until b_us is reached.
struct LoopRange {
  std::uint64_t a_us = 0, b_us = 0;

  bool operator==(const LoopRange&) const = default;
};

inline constexpr double kMinSpeed = 0.1, kMaxSpeed = 4.0;

/// The position of playback, and the only place that knows of time. It never looks at a clock of
/// its own: each call passes the time (`now`, which must not decrease), so that tests need not
/// wait.
class Clock {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  struct Reading {
    std::uint64_t position_us = 0;  ///< in [0, duration]; duration only at the end without loop
    std::uint32_t frame = 0;        ///< to be shown now
    /// Counts frames through all passes, and down in backward play: two readings with no jump
    /// between them differ by k if k frames began between them.
    std::int64_t ordinal = 0;
    /// Playback does not loop, and is past the last frame's duration, or backward past the start.
    bool ended = false;
  };

  /// Paused at the start, speed 1.
  Clock(Timeline timeline, bool loop);

  Reading read(TimePoint now) const;
  /// When the next frame begins, or playback ends; never later, sometimes a little earlier. None
  /// while time stands still.
  std::optional<TimePoint> next_frame(TimePoint now) const;

  /// If it has ended, it begins anew: forward play at the start, backward play at the end.
  void play(TimePoint now);
  void pause(TimePoint now);
  bool playing() const { return playing_; }

  /// Stands still until it is released, although it plays, because the frame is not there.
  void hold(TimePoint now);
  void release(TimePoint now);
  bool held() const { return held_; }

  /// Goes to a time, clamped to the reel, and goes on playing if it played.
  void seek(std::uint64_t time_us, TimePoint now);
  /// Goes forward, or back if negative, but no farther than the start or the end. From the end a
  /// loop begins anew.
  void seek_by(std::int64_t delta_us, TimePoint now);
  /// Pauses, and goes that many frames forward, or back if negative, to exactly that frame's time.
  /// Frames that the next one replaces at the same time, as a cut of video has them, do not count.
  void step(std::int64_t frames, TimePoint now);

  /// Negative: backward. The absolute value is clamped to kMinSpeed and kMaxSpeed. The position
  /// does not jump.
  void set_speed(double speed, TimePoint now);
  double speed() const { return speed_; }
  int direction() const { return speed_ < 0.0 ? -1 : 1; }

  /// The position stays.
  void set_loop(bool loop, TimePoint now);
  bool loop() const { return loop_; }

  /// From now on playback that reaches the far end of the range goes on at its near end, whether
  /// the reel loops or not. The position does not jump, unless it plays and is at the far end. One
  /// can still seek outside: from beyond the far end playback goes on to the reel's end, and from
  /// before the near end it comes into the range. The ends may be given in any order and are
  /// clamped to the reel; if they are equal, the range is the frame there. Seeking and stepping
  /// ignore the range.
  void set_loop_range(const std::optional<LoopRange>& range, TimePoint now);
  const std::optional<LoopRange>& loop_range() const { return range_; }
  /// The frames of the range.
  std::optional<FrameRange> loop_frames() const;

  const Timeline& timeline() const { return timeline_; }

  /// A copy that knows the same position at every time, but has one frame only: small, whatever the
  /// reel.
  Clock without_frames() const;

 private:
  /// A position, which may lie outside the reel if playback does not loop, and Reading::ordinal
  /// less the position's frame.
  struct Place {
    std::int64_t us = 0, passed = 0;
  };
  /// A part that is played again and again: from `begin` until `end` is reached.
  struct Lap {
    std::int64_t begin = 0, end = 0, frames = 0;
  };
  Place place(TimePoint now) const;
  // Whether there is a range, and base_ is such that forward, or backward, play loops in it.
  bool before_far_end() const;
  bool after_near_end() const;
  /// The range, or else the reel; none if playback goes on past the reel's ends.
  std::optional<Lap> lap(bool in_range) const;
  Place forward(std::int64_t by_us) const;
  Place backward(std::int64_t by_us) const;
  /// Makes `now` the new point of reference without a jump.
  void rebase(TimePoint now);
  /// Makes `position_us` the new point of reference. Passes are counted anew.
  void restart_at(std::uint64_t position_us, TimePoint now);

  Timeline timeline_;
  bool loop_;
  bool playing_ = false, held_ = false;
  double speed_ = 1.0;
  std::optional<LoopRange> range_;
  Place base_;  ///< the position at base_now_
  TimePoint base_now_{};
};

}  // namespace pointreel
