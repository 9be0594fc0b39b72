#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "client/scene/frame.h"

namespace pointreel {

/// A frame that somebody is to make.
struct FrameRequest {
  std::uint32_t frame = 0;
  DrawMode mode = DrawMode::surfel;
  int level = kWholeFrame;       ///< the finest level of detail that is seen
  std::uint64_t epoch = 0;       ///< how many jumps came before it
  std::uint64_t generation = 0;  ///< how many changes of mode came before it
};

/// The frames around the playhead, between the threads that make them and the one that shows them.
/// Workers pull: each asks for the frame that is wanted next, so that after a seek the new place
/// comes first by itself. Holds at most `ahead` + 2 finished frames: the window, which is the
/// playhead's frame and `ahead` more in the direction of play, and one that came late. A machine
/// too slow for the reel's rate is always late, and shows at least that. When no frame of the
/// window is missing, those that lack levels which are seen by now are asked for again, the
/// playhead's first. Safe to use from any thread.
class FrameBuffer {
 public:
  struct Options {
    std::uint32_t frame_count = 1;  ///< >= 1
    std::uint32_t ahead = 4;        ///< at most frame_count - 1 counts
    bool loop = true;               ///< the window goes on at the other end of the reel
    DrawMode mode = DrawMode::surfel;
  };
  enum class State { waiting, ready, failed, closed };

  explicit FrameBuffer(const Options& options);

  // For the thread that shows frames.

  /// Playback went on to `frame`; what comes late from before may still be shown.
  void advance(std::uint32_t frame);
  /// A jump: nothing from outside the new window will be shown. `direction` is +1 or -1.
  void seek(std::uint32_t frame, int direction = 1);
  void set_loop(bool loop);
  /// Frames made for another mode are dropped and made again.
  void set_mode(DrawMode mode);
  /// The finest level that is seen: of frames to come, and, if any lack it, of those that are
  /// there. What is finer is kept. kWholeFrame at first.
  void set_level(int level);
  /// The playhead's frame, or else the newest one before it since the last seek; null if none.
  std::shared_ptr<const SceneFrame> best() const;
  /// Waits until the playhead's frame is ready or failed, the buffer is closed, or the time is up.
  /// `fine`: a frame is ready only when it has the level that is seen, or cannot get it.
  State wait(std::chrono::milliseconds timeout, bool fine = false) const;
  /// Ends everybody's wait for good.
  void close();

  // For the threads that make frames.

  /// Waits for something to be wanted; nothing once the buffer is closed. Each request must be
  /// answered by exactly one of deliver, fail and abandon.
  std::optional<FrameRequest> next_wanted();
  /// False if finishing it would be in vain, because of a seek or a change of mode.
  bool wanted(const FrameRequest& request) const;
  /// True if playback has passed the frame.
  bool late(const FrameRequest& request) const;
  /// Keeps the frame if it is still of use.
  void deliver(const FrameRequest& request, std::shared_ptr<const SceneFrame> frame);
  /// There is no such frame: it is not asked for again until the playhead comes back to it.
  void fail(const FrameRequest& request);
  void abandon(const FrameRequest& request);

  /// Finished frames that are held; never more than `ahead` + 2.
  std::size_t held() const;

 private:
  struct Finished {
    std::shared_ptr<const SceneFrame> frame;  ///< null: failed
    int tried = 0;                            ///< the finest level at which it was asked for
  };

  bool lacks_level(const Finished& finished) const {
    return finished.frame && std::max(finished.frame->level, finished.tried) < level_;
  }
  /// Steps from the playhead in the direction of play; the reel's length or more if never reached.
  std::uint32_t distance(std::uint32_t frame) const;
  bool in_window(std::uint32_t frame) const { return distance(frame) <= options_.ahead; }
  std::optional<std::uint32_t> first_missing() const;
  template <class Predicate>
  std::optional<std::uint32_t> first_in_window(const Predicate& predicate) const;
  void move(std::uint32_t frame, bool keep_newest_passed);
  void answered(const FrameRequest& request);
  bool outdated(const FrameRequest& request) const { return request.generation != generation_; }

  Options options_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::uint32_t playhead_ = 0;
  int direction_ = 1;
  std::uint64_t epoch_ = 0, generation_ = 0;
  bool closed_ = false;
  int level_ = kWholeFrame;
  std::map<std::uint32_t, Finished> finished_;  ///< of the window
  std::shared_ptr<const SceneFrame> passed_;    ///< the newest behind the playhead
  /// Being made: how many threads work on it in the mode of now.
  std::map<std::uint32_t, int> in_work_;
};

}  // namespace pointreel
