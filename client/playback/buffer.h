#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "client/playback/layer_store.h"
#include "client/playback/play_order.h"
#include "client/scene/frame.h"

namespace pointreel {

/// A frame that somebody is to make from what has been fetched of it.
struct FrameRequest {
  std::uint32_t frame = 0;
  DrawMode mode = DrawMode::surfel;
  int level = kWholeFrame;       ///< the finest level of detail that is seen
  std::uint32_t layers = 1;      ///< of them it is made
  std::uint64_t epoch = 0;       ///< how many jumps came before it
  std::uint64_t generation = 0;  ///< how many changes of mode came before it
  std::uint64_t order = 0;       ///< how many moves of the playhead came before it
  FetchedFrame fetched;
  double fetch_ms = 0.0;  ///< of what was fetched since the frame was made last
  LayerRange wanted;      ///< what was wanted of it
};

/// Frames that are there, fetched or made, each of this many layers; files count as one.
struct BufferedRange {
  std::uint32_t first = 0, last = 0, layers = 0;

  bool operator==(const BufferedRange&) const = default;
};

/// The frames around the playhead, between the threads that fetch them, those that make them ready
/// to draw, and the one that shows them. Workers pull: each asks for what is wanted next, so that
/// after a jump the new place comes first by itself.
///
/// Fetched, in this order: the base of the playhead's frame; the rest of it, if it is not about to
/// pass; bases of what is near, then their rests; what is further ahead, whole; and what could be
/// finer further ahead. Made: the frames of the window, which is the playhead's and `ahead` more in
/// the direction of play, first those that are missing, then those that could be finer by now.
///
/// While scrubbing, the base of the frame under the cursor is all that is made, and all that is
/// fetched until it is there: then come the bases beside it, which a hand mostly asks for next.
/// What was asked for before is cancelled, but for the cursor's place before, so that a drag that
/// is faster than the link still shows where it passed.
///
/// Holds at most `ahead` + 2 finished frames: the window, and one that came late. A machine too
/// slow for the reel's rate is always late, and shows at least that. Safe to use from any thread.
class FrameBuffer {
 public:
  /// What is wanted of a frame for this mode and level. Called with the buffer locked: it must not
  /// call back, nor wait for anybody who does.
  using Choice = std::function<LayerRange(std::uint32_t frame, DrawMode mode, int level)>;

  struct Options {
    std::uint32_t frame_count = 1;  ///< >= 1
    std::uint32_t ahead = 4;        ///< frames made; at most frame_count - 1 counts
    bool loop = true;               ///< the window goes on at the other end of the reel
    DrawMode mode = DrawMode::surfel;
    std::uint32_t fetch_ahead = 0;  ///< frames fetched; at least `ahead`
    /// Frames whose bases come before all rests; on both sides of the cursor while scrubbing.
    std::uint32_t near = 0;
    bool base_first = false;  ///< a base is fetched by itself
    /// Of coded frames; those in the window of `ahead` are kept, and those fetched, anyway.
    std::uint64_t store_bytes = 0;
    /// The finest level that is there with one layer, with two, ...; >= 1 entries, the last
    /// kWholeFrame.
    std::vector<int> levels = {kWholeFrame};
    Choice choice;  ///< default: everything
    /// Called by any thread when more of a frame was fetched, or one is ready or cannot be had. As
    /// `choice`, it must not call back.
    std::function<void()> on_ready = {};
  };
  enum class State { waiting, ready, failed, closed };

  explicit FrameBuffer(Options options);

  // For the thread that shows frames.

  /// Playback went on to `frame`; what comes late from before may still be shown. `direction` is +1
  /// or -1.
  void advance(std::uint32_t frame, int direction = 1);
  /// A jump: nothing from outside the new window will be shown.
  void seek(std::uint32_t frame, int direction = 1);
  /// The cursor of a drag is at this frame. Lasts until the next seek.
  void scrub(std::uint32_t frame);
  void set_loop(bool loop);
  /// After the range's end its beginning is what comes next; all frames if none.
  void set_loop_range(const std::optional<FrameRange>& range);
  /// Frames are made for this mode, or by other rules for the same: those that are ready are
  /// dropped and made again.
  void make_again(DrawMode mode);
  /// The finest level that is seen: of frames to come, and, if any lack it, of those that are
  /// there. What is finer is kept. kWholeFrame at first.
  void set_level(int level);
  struct Pace {
    std::uint32_t fetch_ahead = 0;  ///< Options::fetch_ahead
    std::uint32_t lead = 0;         ///< frames before its time from which on none is refined
    bool base_first = false;        ///< Options::base_first
    /// The playhead's frame is waited for: until it is as fine as can be, nothing else is fetched
    /// or made, and then one frame at a time.
    bool focus = false;
    /// The playhead's frame is made of its base first, even where all of it is there.
    bool coarse_first = false;
    bool operator==(const Pace&) const = default;
  };
  void set_pace(const Pace& pace);
  /// Options::choice says something else by now.
  void choice_changed() { wake_all(); }

  /// The playhead's frame, or else the newest one before it since the last seek; null if none.
  /// While scrubbing: the cursor's, or else the newest of where the cursor was.
  std::shared_ptr<const SceneFrame> best() const;
  /// Waits until the playhead's frame is ready or failed, the buffer is closed, or the time is up.
  /// `fine`: a frame is ready only when it has the level that is seen, or cannot get it.
  State wait(std::chrono::milliseconds timeout, bool fine = false) const;
  /// How full the buffer is, in frames from the playhead's on without a gap.
  struct Fill {
    std::uint32_t fetched = 0;  ///< their base, at least, or broken
    std::uint32_t made = 0;     ///< or broken
    std::uint32_t window = 0;   ///< that would be fetched
    std::uint32_t ahead = 0;    ///< that would be made
    bool full = false;          ///< no more is fetched for want of room
    std::uint32_t next = 0;     ///< the first frame that is not fetched; the last one if all are
  };
  Fill fill() const;
  /// In order, as few as can be. Cheap enough for every picture.
  std::vector<BufferedRange> buffered() const;
  /// Ends everybody's wait for good.
  void close();

  // For the threads that fetch. Each request is answered by exactly one of fetched, fetch_failed
  // and fetch_stopped.

  /// Waits for something to be wanted; nothing once the buffer is closed.
  std::optional<FetchRequest> next_fetch();
  void fetched(const FetchRequest& request, FetchedFrame frame, double ms);
  /// It cannot be had: the frame does with coarser layers, or, without any, is not asked for again
  /// until the playhead comes back to it.
  void fetch_failed(const FetchRequest& request);
  void fetch_stopped(const FetchRequest& request);

  // For the threads that make frames. Each request is answered by exactly one of deliver and
  // broken.

  std::optional<FrameRequest> next_wanted();
  /// Keeps the frame if it is still of use.
  void deliver(const FrameRequest& request, std::shared_ptr<const SceneFrame> frame);
  /// This layer of what was fetched does not decode. True: it is fetched once more. False: it was
  /// already, and the frame does with the layers before, or, without any, there is no such frame.
  bool broken(const FrameRequest& request, std::uint32_t layer);

  /// Finished frames that are held; never more than `ahead` + 2.
  std::size_t held() const;
  std::uint64_t held_bytes() const;    ///< that they take
  std::uint64_t stored_bytes() const;  ///< of coded frames
  /// What has been fetched of the frame, if its base is there with these attributes: the base.
  std::optional<FetchedFrame> stored_base(std::uint32_t frame, bool colors, bool normals) const;

 private:
  struct Finished {
    std::shared_ptr<const SceneFrame> frame;  ///< null: failed
    int tried = 0;                            ///< the finest level at which it was asked for
    LayerRange made_of;                       ///< attributes
  };
  struct Making {
    int level = 0;  ///< the finest
    int threads = 0;
  };

  LayerRange wanted(std::uint32_t frame) const;
  int target(std::uint32_t layers) const;
  bool lacks(std::uint32_t frame, int level, const LayerRange& attributes) const;
  bool satisfied(std::uint32_t frame) const;
  bool done_with(std::uint32_t frame) const;
  /// Steps from the playhead in the direction of play; the reel's length or more if never reached.
  std::uint32_t distance(std::uint32_t frame) const;
  PlayOrder order(int direction) const {
    return {options_.frame_count, options_.loop, direction, loop_range_};
  }
  /// The frame so many steps from the playhead; none beyond the reel's end.
  std::optional<std::uint32_t> at(std::uint32_t step) const;
  void order_changed();
  bool in_window(std::uint32_t frame) const {
    return distance(frame) <= (scrubbing_ ? 0 : options_.ahead);
  }
  bool in_fetch_window(std::uint32_t frame) const {
    return distance(frame) <= (scrubbing_ ? 0 : fetch_ahead_);
  }
  bool has_room() const;
  bool focused() const { return focus_ && !satisfied(playhead_); }
  std::optional<FetchRequest> find_fetch();
  std::optional<FetchRequest> begin(std::uint32_t step, bool base_only);
  std::optional<FetchRequest> begin_beside_cursor();
  std::optional<FrameRequest> find_wanted();
  std::optional<FrameRequest> make(std::uint32_t step, bool again);
  void move(std::uint32_t frame, int direction, bool keep_newest_passed);
  std::uint32_t behind(std::uint32_t frame) const;
  void answered(const FrameRequest& request);
  void wake_all();
  void tell_ready();
  bool outdated(const FrameRequest& request) const { return request.generation != generation_; }

  Options options_;
  mutable std::mutex mutex_;
  mutable std::condition_variable shown_changed_;  ///< for who shows
  std::condition_variable to_fetch_, to_make_;     ///< for workers; each wakes the next
  std::uint32_t playhead_ = 0;
  int direction_ = 1;
  std::optional<FrameRange> loop_range_;
  std::uint32_t fetch_ahead_ = 0, lead_ = 0;
  bool focus_ = false, coarse_first_ = false;
  bool scrubbing_ = false, dragged_back_ = false;
  std::uint64_t epoch_ = 0, generation_ = 0, order_ = 0;
  bool closed_ = false;
  int level_ = kWholeFrame;
  LayerStore store_;
  std::map<std::uint32_t, Finished> finished_;  ///< of the window
  std::shared_ptr<const SceneFrame> passed_;    ///< the newest behind the playhead
  std::uint64_t passed_order_ = 0;              ///< of its request, while scrubbing
  std::map<std::uint32_t, Making> making_;      ///< in the mode of now
};

}  // namespace pointreel
