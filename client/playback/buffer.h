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
#include <stop_token>
#include <vector>

#include "client/playback/layer_store.h"
#include "client/playback/play_order.h"
#include "client/scene/frame.h"

namespace pointreel {

/// A frame to be made ready to draw from what has been fetched of it.
struct FrameRequest {
  std::uint32_t frame = 0;
  DrawMode mode = DrawMode::surfel;
  int level = kWholeFrame;   ///< the finest level of detail that is seen
  std::uint32_t layers = 1;  ///< how many layers it is made of
  // What came before the request.
  std::uint64_t epoch = 0;       ///< jumps
  std::uint64_t generation = 0;  ///< changes after which frames are made again
  std::uint64_t order = 0;       ///< moves of the playhead
  FetchedFrame fetched;
  double fetch_ms = 0.0;  ///< how long it took to fetch what is new since the frame was last made
  LayerRange wanted;      ///< what was wanted of the frame
  std::stop_token stop;   ///< asks to stop: the frame will not be shown
};

/// Consecutive frames that have been fetched or made, each with this many layers. Files count as
/// one layer.
struct BufferedRange {
  std::uint32_t first = 0, last = 0, layers = 0;

  bool operator==(const BufferedRange&) const = default;
};

/// The frames around the playhead, between the threads that fetch them, the threads that make them
/// ready to draw, and the thread that shows them. Workers pull: each asks what is wanted next, so
/// that after a jump the new place comes first without further ado.
///
/// Frames are fetched in this order: the base of the playhead's frame; the rest of that frame,
/// unless it is about to pass; the bases of frames that are near, then their rests; frames further
/// ahead, whole; and finally what could be finer further ahead. The frames of the window are made
/// ready, that is the playhead's frame and `ahead` more in the direction of play: first those that
/// are missing, then those that could be finer by now.
///
/// While the user drags the time (scrubbing), only the base of the frame under the cursor is made,
/// and it alone is fetched until it is there. Then come the bases beside it, which a hand mostly
/// asks for next. Earlier requests are cancelled, except the one for the cursor's previous place,
/// so that a drag that is faster than the link still shows where it passed.
///
/// A jump also stops the making of frames that it leaves behind, and so does the beginning of a
/// drag, so that the threads are free for what the user asked for.
///
/// Holds the finished frames of the window, one frame that came late, and, within a memory budget,
/// finished frames outside the window: a loop that fits into it is made once. Those that playback
/// reaches last are dropped first. A machine that is too slow for the reel's rate is always late,
/// and shows at least the late frame. Safe to use from any thread.
class FrameBuffer {
 public:
  /// What is wanted of a frame for this mode and level. Called with the buffer locked: it must not
  /// call the buffer, nor wait for a thread that does.
  using Choice = std::function<LayerRange(std::uint32_t frame, DrawMode mode, int level)>;

  struct Options {
    std::uint32_t frame_count = 1;  ///< >= 1
    std::uint32_t ahead = 4;        ///< how many frames are made; no more than frame_count - 1
    bool loop = true;               ///< the window goes on at the other end of the reel
    DrawMode mode = DrawMode::surfel;
    std::uint32_t fetch_ahead = 0;  ///< how many frames are fetched; at least `ahead`
    /// How many frames count as near: their bases come before the rest of any. While scrubbing, on
    /// both sides of the cursor.
    std::uint32_t near = 0;
    bool base_first = false;  ///< a base is fetched by itself
    /// How many bytes of coded frames are kept, besides those of the window of `ahead` and those
    /// that are just being fetched.
    std::uint64_t store_bytes = 0;
    std::uint64_t cache_bytes = 0;  ///< of finished frames outside the window that are kept
    /// The finest level that a frame has with one layer, with two, and so on. The last entry is
    /// kWholeFrame.
    std::vector<int> levels = {kWholeFrame};
    Choice choice;  ///< default: everything
    /// Called by any thread when more of a frame was fetched, or a frame is ready or failed. It is
    /// bound as `choice` is.
    std::function<void()> on_ready = {};
  };
  enum class State { waiting, ready, failed, closed };

  explicit FrameBuffer(Options options);

  // For the thread that shows frames.

  /// Playback went on to `frame`. Earlier frames that come late may still be shown. `direction` is
  /// +1 or -1.
  void advance(std::uint32_t frame, int direction = 1);
  /// A jump. No frame from outside the new window is shown any more.
  void seek(std::uint32_t frame, int direction = 1);
  /// The time is being dragged, and the cursor is at this frame. Lasts until the next seek.
  void scrub(std::uint32_t frame);
  void set_loop(bool loop);
  /// Playback that reaches the range's end goes on at its beginning. None: all frames.
  void set_loop_range(const std::optional<FrameRange>& range);
  /// Frames are to be made for another mode, or differently for the same: those that are ready are
  /// dropped and made again.
  void make_again(DrawMode mode);
  /// The finest level that is seen. Frames that lack it are refined, and finer ones are kept.
  /// kWholeFrame at first.
  void set_level(int level);
  struct Pace {
    std::uint32_t fetch_ahead = 0;  ///< Options::fetch_ahead
    std::uint32_t lead = 0;   ///< a frame is not refined any more this many frames before its time
    bool base_first = false;  ///< Options::base_first
    /// The user waits for the playhead's frame: until it is as fine as possible, nothing else is
    /// fetched or made, and then one frame at a time.
    bool focus = false;
    /// The playhead's frame is made of its base first, even if all of it has come.
    bool coarse_first = false;
    bool operator==(const Pace&) const = default;
  };
  void set_pace(const Pace& pace);
  /// Call this when Options::choice has another answer than before.
  void choice_changed() { wake_all(); }

  /// The playhead's frame, or else the newest frame before it since the last seek; null if there is
  /// none. While scrubbing: the frame under the cursor, or else the newest where the cursor was.
  std::shared_ptr<const SceneFrame> best() const;
  /// Waits until the playhead's frame is ready or failed, the buffer is closed, or the time is up.
  /// With `fine`, a frame is ready only when it has the level that is seen, or cannot get it.
  State wait(std::chrono::milliseconds timeout, bool fine = false) const;
  /// How full the buffer is. Frames count from the playhead's on, up to the first gap.
  struct Fill {
    std::uint32_t fetched = 0;  ///< frames whose base, at least, has come; broken ones count, too
    std::uint32_t made = 0;     ///< frames that are ready, or broken
    std::uint32_t window = 0;   ///< frames that would be fetched
    std::uint32_t ahead = 0;    ///< frames that would be made
    bool full = false;          ///< there is no room to fetch more
    std::uint32_t next = 0;     ///< the first frame that has not been fetched; the last if all have
  };
  Fill fill() const;
  /// What has been fetched or made, in order, in as few ranges as possible. Cheap enough to call
  /// for every picture.
  std::vector<BufferedRange> buffered() const;
  /// Ends all waiting, now and later.
  void close();

  // For the threads that fetch. Each request is answered by exactly one of fetched, fetch_failed
  // and fetch_stopped.

  /// Waits until something is wanted; none once the buffer is closed.
  std::optional<FetchRequest> next_fetch();
  void fetched(const FetchRequest& request, FetchedFrame frame, double ms);
  /// The layers are not to be had. The frame is shown with coarser layers; if there are none, it is
  /// not requested again until the playhead comes back to it.
  void fetch_failed(const FetchRequest& request);
  void fetch_stopped(const FetchRequest& request);

  // For the threads that make frames. Each request is answered by exactly one of deliver, broken
  // and make_stopped.

  std::optional<FrameRequest> next_wanted();
  /// Keeps the frame if it is still useful.
  void deliver(const FrameRequest& request, std::shared_ptr<const SceneFrame> frame);
  /// A layer does not decode. True: it is fetched once more. False: it had been fetched again
  /// before, so that the frame is shown with the layers before it, or fails if there are none.
  bool broken(const FrameRequest& request, std::uint32_t layer);
  /// The frame was not made because the request was stopped.
  void make_stopped(const FrameRequest& request);

  std::size_t held() const;            ///< finished frames; `ahead` + 2 and those that are kept
  std::uint64_t held_bytes() const;    ///< that the finished frames take
  std::uint64_t stored_bytes() const;  ///< of coded frames
  /// How often the playhead came back to a frame that was still finished from an earlier time.
  std::uint64_t reused() const;
  /// The base of a frame as it was fetched, if it has come with these attributes.
  std::optional<FetchedFrame> stored_base(std::uint32_t frame, bool colors, bool normals) const;

 private:
  struct Finished {
    std::shared_ptr<const SceneFrame> frame;  ///< null: it failed
    int tried = 0;                            ///< the finest level that it was made for
    LayerRange made_of;                       ///< its attributes count
    bool passed = false;                      ///< the playhead was here before
  };
  struct Making {
    int level = 0;  ///< the finest that any of the threads makes
    int threads = 0;
    std::stop_source stop = {};
  };
  static constexpr LayerRange kBase{0, 1, false, false};

  LayerRange wanted(std::uint32_t frame) const;
  int target(std::uint32_t layers) const;
  bool lacks(std::uint32_t frame, int level, const LayerRange& attributes) const;
  bool satisfied(std::uint32_t frame) const;
  bool done_with(std::uint32_t frame) const;
  /// Steps from the playhead in the direction of play; the reel's length or more if playback never
  /// reaches the frame.
  std::uint32_t distance(std::uint32_t frame) const;
  PlayOrder order(int direction) const {
    return {options_.frame_count, options_.loop, direction, loop_range_};
  }
  /// The frame `step` steps from the playhead; none beyond the reel's end.
  std::optional<std::uint32_t> at(std::uint32_t step) const;
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
  void trim();
  std::uint32_t behind(std::uint32_t frame) const;
  void answered(const FrameRequest& request);
  void keep(const FrameRequest& request, std::shared_ptr<const SceneFrame> frame);
  template <class Stale>
  void stop_making(Stale stale);
  void wake_all();
  void tell_ready();
  bool outdated(const FrameRequest& request) const { return request.generation != generation_; }

  Options options_;
  mutable std::mutex mutex_;
  mutable std::condition_variable shown_changed_;  ///< for the thread that shows frames
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
  std::map<std::uint32_t, Finished> finished_;  ///< frames of the window, and those that are kept
  std::uint64_t reused_ = 0;
  std::shared_ptr<const SceneFrame> passed_;  ///< the newest frame behind the playhead
  std::uint64_t passed_order_ = 0;            ///< FrameRequest::order of it, while scrubbing
  /// Frames being made in the current mode, without those that were stopped.
  std::map<std::uint32_t, Making> making_;
};

}  // namespace pointreel
