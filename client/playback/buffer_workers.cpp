// What the workers of a FrameBuffer do next, and what becomes of it. buffer.cpp has the rest.

#include <algorithm>
#include <utility>

#include "client/playback/buffer.h"

namespace pointreel {
namespace {

/// Frames nearer than this are made of what has come; those further ahead may wait for the rest.
constexpr std::uint32_t kSoon = 2;
/// How many bases beside the cursor are fetched at once: one waits for the link's delay while
/// another comes. With four, those under way held up the frame that the cursor jumped to.
constexpr std::size_t kBesideCursor = 2;

}  // namespace

// What is wanted.

LayerRange FrameBuffer::wanted(std::uint32_t frame) const {
  LayerRange wanted = options_.choice(frame, options_.mode, level_);
  const auto all = static_cast<std::uint32_t>(options_.levels.size());
  std::uint32_t seen = 1;
  while (seen < all && options_.levels[seen - 1] < level_) ++seen;
  wanted.end = scrubbing_ ? 1 : std::clamp(wanted.end, 1u, seen);
  return wanted;
}

/// The level that can be seen of a frame made of this many layers.
int FrameBuffer::target(std::uint32_t layers) const {
  return std::min(level_, options_.levels[layers - 1]);
}

bool FrameBuffer::lacks(std::uint32_t frame, int level, const LayerRange& attributes) const {
  const auto it = finished_.find(frame);
  if (it == finished_.end()) return true;
  const Finished& finished = it->second;
  if (std::max(finished.frame ? finished.frame->level : 0, finished.tried) < level) return true;
  return finished.frame && ((attributes.colors && !finished.made_of.colors) ||
                            (attributes.normals && !finished.made_of.normals));
}

/// True if fetching more of the frame would not make it finer.
bool FrameBuffer::satisfied(std::uint32_t frame) const {
  const LayerRange want = wanted(frame);
  const std::uint32_t layers = std::min(want.end, store_.limit(frame));
  return layers == 0 || !lacks(frame, target(layers), want);
}

bool FrameBuffer::has_room() const {
  return store_.bytes() + store_.coming_bytes() < options_.store_bytes;
}

std::optional<FetchRequest> FrameBuffer::begin(std::uint32_t step, bool base_only) {
  const auto frame = at(step);
  if (!frame || satisfied(*frame)) return std::nullopt;
  LayerRange want = wanted(*frame);
  if (base_only) want.end = 1;
  return store_.begin(*frame, want);
}

/// Once the base under the cursor is there, requests the nearest base that is neither there nor
/// coming: first in the direction in which the cursor goes, then where it came from.
std::optional<FetchRequest> FrameBuffer::begin_beside_cursor() {
  if (store_.coming(playhead_, kBase) || store_.requests() >= kBesideCursor || !has_room())
    return std::nullopt;
  for (const bool back : {dragged_back_, !dragged_back_}) {
    for (std::uint32_t away = 1; away <= options_.near; ++away) {
      if (back ? away > playhead_ : away >= options_.frame_count - playhead_) continue;
      const std::uint32_t frame = back ? playhead_ - away : playhead_ + away;
      if (auto request = store_.begin(frame, wanted(frame))) return request;
    }
  }
  return std::nullopt;
}

std::optional<FetchRequest> FrameBuffer::find_fetch() {
  const bool split = options_.base_first || scrubbing_;
  if (auto request = begin(0, split)) return request;
  if (scrubbing_) return begin_beside_cursor();
  if (lead_ == 0) {
    if (auto request = begin(0, false)) return request;
  }
  if (focused() && store_.coming(playhead_, {})) return std::nullopt;
  const std::uint32_t near = std::min(std::max(options_.near, 1u) - 1, fetch_ahead_);
  if (split) {
    for (std::uint32_t step = 1; step <= near; ++step)
      if (auto request = begin(step, true)) return request;
  }
  for (std::uint32_t step = std::max(1u, lead_); step <= near; ++step)
    if (auto request = begin(step, false)) return request;
  for (std::uint32_t step = near + 1; step <= fetch_ahead_; ++step) {
    if (step > options_.ahead && !has_room()) return std::nullopt;
    const auto frame = at(step);
    if (!frame) break;
    // Frames that have their base wait until nothing else is wanted.
    if (store_.usable(*frame, kBase) > 0 || store_.coming(*frame, {})) continue;
    if (auto request = begin(step, false)) return request;
  }
  for (std::uint32_t step = std::max(near + 1, lead_); step <= fetch_ahead_; ++step)
    if (auto request = begin(step, false)) return request;
  return std::nullopt;
}

std::optional<FetchRequest> FrameBuffer::next_fetch() {
  std::unique_lock lock(mutex_);
  std::optional<FetchRequest> request;
  to_fetch_.wait(lock, [&] { return closed_ || (request = find_fetch()).has_value(); });
  if (closed_) return std::nullopt;
  to_fetch_.notify_one();
  return request;
}

void FrameBuffer::fetched(const FetchRequest& request, FetchedFrame frame, double ms) {
  {
    const std::lock_guard lock(mutex_);
    store_.arrived(request, std::move(frame), ms);
    store_.shrink(options_.store_bytes, [this](std::uint32_t f) -> std::uint64_t {
      return in_fetch_window(f) ? 0 : distance(f);
    });
  }
  to_make_.notify_one();
  tell_ready();
}

void FrameBuffer::fetch_failed(const FetchRequest& request) {
  {
    const std::lock_guard lock(mutex_);
    if (!store_.give_up(request) && in_window(request.frame)) finished_[request.frame];
  }
  wake_all();
  tell_ready();
}

void FrameBuffer::fetch_stopped(const FetchRequest& request) {
  {
    const std::lock_guard lock(mutex_);
    store_.failed(request);
  }
  wake_all();
}

std::optional<FrameRequest> FrameBuffer::make(std::uint32_t step, bool again) {
  const auto frame = at(step);
  if (!frame || finished_.contains(*frame) != again) return std::nullopt;
  const LayerRange want = wanted(*frame);
  std::uint32_t layers = store_.usable(*frame, want);
  if (layers == 0) {
    // It failed before: the playhead has come back to it, or it was given up before it came into
    // the window.
    if (!again && store_.limit(*frame) == 0) {
      finished_[*frame];
      tell_ready();
    }
    return std::nullopt;
  }
  const auto making = making_.find(*frame);
  // Other threads make the whole frame at the same time.
  const bool coarse = coarse_first_ && step == 0 && !again && making == making_.end() && layers > 1;
  if (coarse) layers = 1;
  const int level = target(layers);
  if (making != making_.end() && making->second.level >= level) return std::nullopt;
  if (!again && step > kSoon && store_.coming(*frame, want)) return std::nullopt;
  if (again && (step < lead_ || !lacks(*frame, level, want))) return std::nullopt;
  Making& work = making_[*frame];
  work.level = std::max(work.level, level);
  ++work.threads;
  FrameRequest request;
  request.frame = *frame;
  request.mode = options_.mode;
  request.level = level_;
  request.layers = layers;
  request.epoch = epoch_;
  request.generation = generation_;
  request.order = order_;
  request.fetched = store_.get(*frame, layers);
  // Either of the two may be shown first, so that both tell the time.
  request.fetch_ms = coarse ? store_.fetch_ms(*frame) : store_.take_fetch_ms(*frame);
  request.wanted = want;
  request.stop = work.stop.get_token();
  return request;
}

std::optional<FrameRequest> FrameBuffer::find_wanted() {
  const std::uint32_t last = scrubbing_ || focused() ? 0 : options_.ahead;
  for (const bool again : {false, true})
    for (std::uint32_t step = 0; step <= last; ++step) {
      // A user who looks at one frame may jump to another at any time: a thread is kept free for
      // that.
      if (step > 0 && focus_ && !making_.empty()) continue;
      if (auto request = make(step, again)) return request;
    }
  return std::nullopt;
}

std::optional<FrameRequest> FrameBuffer::next_wanted() {
  std::unique_lock lock(mutex_);
  std::optional<FrameRequest> request;
  to_make_.wait(lock, [&] { return closed_ || (request = find_wanted()).has_value(); });
  if (closed_) return std::nullopt;
  to_make_.notify_one();
  return request;
}

void FrameBuffer::answered(const FrameRequest& request) {
  if (outdated(request)) return;
  const auto it = making_.find(request.frame);
  if (it == making_.end() || it->second.stop.get_token() != request.stop) return;
  if (--it->second.threads <= 0) making_.erase(it);
}

/// Adds what was made to the finished frames.
void FrameBuffer::keep(const FrameRequest& request, std::shared_ptr<const SceneFrame> frame) {
  Finished& finished = finished_[request.frame];
  const int level = std::min(request.level, options_.levels[request.layers - 1]);
  // Two threads may have made it, each from what had come when it began.
  if (!finished.frame || finished.frame->level <= frame->level) {
    finished.frame = std::move(frame);
    finished.made_of = request.wanted;
    finished.passed = false;
  }
  finished.tried = std::max(finished.tried, level);
}

void FrameBuffer::deliver(const FrameRequest& request, std::shared_ptr<const SceneFrame> frame) {
  {
    const std::lock_guard lock(mutex_);
    answered(request);
    if (outdated(request)) {
      // Better than nothing for a user who changes settings faster than frames are made.
      if (request.mode != options_.mode || request.frame != playhead_ || request.epoch != epoch_)
        return;
      passed_ = std::move(frame);
    } else if (in_window(request.frame)) {
      keep(request, std::move(frame));
      if (focus_ && satisfied(playhead_)) {
        to_fetch_.notify_all();
        to_make_.notify_all();
      }
      // Coded frames that are cheap to fetch again are not kept.
      if (options_.store_bytes == 0 && satisfied(request.frame))
        store_.shrink(0, [&](std::uint32_t f) -> std::uint64_t { return f == request.frame; });
    } else {
      // It comes too late for now, but the playhead may come back to it.
      if (options_.cache_bytes > 0) {
        keep(request, frame);
        trim();
      }
      if (request.epoch != epoch_) {
        // It is from before a jump.
      } else if (scrubbing_) {
        if (request.order > passed_order_) {
          passed_order_ = request.order;
          passed_ = std::move(frame);
        }
      } else if (!passed_ || behind(request.frame) < behind(passed_->index)) {
        // It is late. Of two late frames the one that lies less far behind is newer.
        passed_ = std::move(frame);
      }
    }
  }
  tell_ready();
}

bool FrameBuffer::broken(const FrameRequest& request, std::uint32_t layer) {
  bool again = false;
  {
    const std::lock_guard lock(mutex_);
    answered(request);
    again = store_.broken(request.frame, layer);
    if (!again && store_.limit(request.frame) == 0 && !outdated(request) &&
        in_window(request.frame))
      finished_[request.frame];  // a frame that is there stays
  }
  wake_all();
  tell_ready();
  return again;
}

void FrameBuffer::make_stopped(const FrameRequest& request) {
  {
    const std::lock_guard lock(mutex_);
    answered(request);
  }
  to_make_.notify_one();
}

}  // namespace pointreel
