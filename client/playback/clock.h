#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "client/playback/play_order.h"

namespace pointreel {

/// When each frame of a reel begins, microseconds from its start, not decreasing, and how long one
/// pass takes. At least one frame; duration_us > 0.
struct Timeline {
  std::vector<std::uint64_t> times_us;
  std::uint64_t duration_us = 0;

  std::uint32_t frame_count() const { return static_cast<std::uint32_t>(times_us.size()); }
  /// The last frame that begins at or before `time_us`; the first if there is none.
  std::uint32_t frame_at(std::uint64_t time_us) const;
};

/// What is played again and again: from a_us on until b_us is reached.
struct LoopRange {
  std::uint64_t a_us = 0, b_us = 0;

  bool operator==(const LoopRange&) const = default;
};

inline constexpr double kMinSpeed = 0.1, kMaxSpeed = 4.0;

/// Where playback stands, and its only owner of time. It never asks what time it is: each call says
/// so (`now`, which must not decrease), so that it can be tested without waiting.
class Clock {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  struct Reading {
    std::uint64_t position_us = 0;  ///< in [0, duration]; duration only at the end without loop
    std::uint32_t frame = 0;        ///< to be seen now
    /// Counts frames through all passes, down in backward play: differs by k between two readings
    /// with no jump between them if k frames began between them.
    std::int64_t ordinal = 0;
    /// Not looping, and past the last frame's own duration, or backward past the reel's start.
    bool ended = false;
  };

  /// Paused at the start, speed 1.
  Clock(Timeline timeline, bool loop);

  Reading read(TimePoint now) const;
  /// When the next frame begins, or playback ends; never later, sometimes a little earlier. None
  /// while time stands still.
  std::optional<TimePoint> next_frame(TimePoint now) const;

  /// From the end, without loop, begins anew; so does backward play from the start, at the end.
  void play(TimePoint now);
  void pause(TimePoint now);
  bool playing() const { return playing_; }

  /// Stands still, though it plays, until it is released: what is to be seen is not there.
  void hold(TimePoint now);
  void release(TimePoint now);
  bool held() const { return held_; }

  /// Goes to a time, clamped to the reel, and keeps on playing if it played.
  void seek(std::uint64_t time_us, TimePoint now);
  /// Goes forward, or back if negative: no farther than the start, nor than the end, where a loop
  /// begins anew.
  void seek_by(std::int64_t delta_us, TimePoint now);
  /// Pauses and goes `frames` on, or back: exactly to that frame's time.
  void step(std::int64_t frames, TimePoint now);

  /// Negative: backward. Clamped to between kMinSpeed and kMaxSpeed either way; the position does
  /// not jump.
  void set_speed(double speed, TimePoint now);
  double speed() const { return speed_; }
  int direction() const { return speed_ < 0.0 ? -1 : 1; }

  /// Switching it keeps the position.
  void set_loop(bool loop, TimePoint now);
  bool loop() const { return loop_; }

  /// From now on whoever reaches its far end goes on at the near one, whether the reel loops or
  /// not; the position does not jump, except if it plays and is at that end. What lies outside can
  /// still be gone to: past the far end playback goes on to the reel's end, and from before the
  /// near one it comes into the range. The ends may be given in any order and are clamped to the
  /// reel; if they are the same, it is the frame there. Seeking and stepping know nothing of it.
  void set_loop_range(const std::optional<LoopRange>& range, TimePoint now);
  const std::optional<LoopRange>& loop_range() const { return range_; }
  /// The frames that are seen in it.
  std::optional<FrameRange> loop_frames() const;

  const Timeline& timeline() const { return timeline_; }

 private:
  /// A position, neither clamped nor, without loop, in the reel, and Reading::ordinal less its
  /// frame.
  struct Place {
    std::int64_t us = 0, passed = 0;
  };
  /// What is played again and again: from begin on until end is reached.
  struct Lap {
    std::int64_t begin = 0, end = 0, frames = 0;
  };
  Place place(TimePoint now) const;
  // Of the range, if there is one: playing forward, or backward, from base_ turns around there.
  bool before_far_end() const;
  bool after_near_end() const;
  /// The range, or else the reel; none if playback goes on past its ends.
  std::optional<Lap> lap(bool in_range) const;
  Place forward(std::int64_t by_us) const;
  Place backward(std::int64_t by_us) const;
  /// Makes `now` the new point of reference without a jump.
  void rebase(TimePoint now);
  /// Makes `position_us`, in no pass before any other, the new point of reference.
  void restart_at(std::uint64_t position_us, TimePoint now);

  Timeline timeline_;
  bool loop_;
  bool playing_ = false, held_ = false;
  double speed_ = 1.0;
  std::optional<LoopRange> range_;
  Place base_;  ///< at base_now_
  TimePoint base_now_{};
};

}  // namespace pointreel
