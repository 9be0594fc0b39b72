#include "client/playback/buffer.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace pointreel {
namespace {

std::uint32_t apart(std::uint32_t a, std::uint32_t b) { return a > b ? a - b : b - a; }

}  // namespace

FrameBuffer::FrameBuffer(Options options)
    : options_(std::move(options)),
      store_(static_cast<std::uint32_t>(std::max<std::size_t>(1, options_.levels.size()))) {
  options_.ahead = std::min(options_.ahead, options_.frame_count - 1);
  if (options_.levels.empty()) options_.levels = {kWholeFrame};
  if (!options_.choice) options_.choice = [](std::uint32_t, DrawMode, int) { return LayerRange{}; };
  fetch_ahead_ = std::clamp(options_.fetch_ahead, options_.ahead, options_.frame_count - 1);
}

void FrameBuffer::wake_all() {
  shown_changed_.notify_all();
  to_fetch_.notify_all();
  to_make_.notify_all();
}

/// For the thread that shows frames.
void FrameBuffer::tell_ready() {
  shown_changed_.notify_all();
  if (options_.on_ready) options_.on_ready();
}

// Where the playhead is.

std::uint32_t FrameBuffer::distance(std::uint32_t frame) const {
  if (const auto steps = order(direction_).steps(playhead_, frame)) return *steps;
  return options_.frame_count + apart(frame, playhead_);
}

std::uint32_t FrameBuffer::behind(std::uint32_t frame) const {
  return order(direction_).steps(frame, playhead_).value_or(options_.frame_count);
}

std::optional<std::uint32_t> FrameBuffer::at(std::uint32_t step) const {
  return order(direction_).after(playhead_, step);
}

void FrameBuffer::move(std::uint32_t frame, int direction, bool keep_newest_passed) {
  const std::uint32_t before = playhead_;
  const int direction_before = direction_;
  const PlayOrder order_before = order(direction_);
  const std::uint32_t last_before = scrubbing_ ? 0 : options_.ahead;
  playhead_ = std::min(frame, options_.frame_count - 1);
  direction_ = direction < 0 ? -1 : 1;
  ++order_;
  // Among the frames that the playhead left behind, the nearest is kept until there is a newer one.
  // If the whole of what is played fits the window, they are still in it.
  const std::uint32_t moved = order_before.steps(before, playhead_).value_or(0);
  // What could not be had is tried again when it comes into the window again. A short loop never
  // leaves the window, so what the playhead has left behind, or jumped from, counts as outside.
  const auto forgiven = [&](std::uint32_t f) {
    return !in_fetch_window(f) || !keep_newest_passed ||
           order_before.steps(before, f).value_or(0) < moved;
  };
  std::int64_t newest = -1;
  std::shared_ptr<const SceneFrame> passed;
  for (auto it = finished_.begin(); it != finished_.end();) {
    const auto steps = order_before.steps(before, it->first);
    const std::uint32_t from = steps.value_or(0);
    const bool was_in_window = steps && *steps <= last_before;
    const bool stays = in_window(it->first);
    // Frames that were ahead, and are behind only because playback turned around, were never shown.
    const bool was_passed =
        was_in_window && (direction_ == direction_before || from == 0) && (!stays || from < moved);
    if (it->second.frame && was_passed && from > newest) {
      newest = from;
      passed = it->second.frame;
    }
    const bool failed = !it->second.frame;
    it = failed && forgiven(it->first) ? finished_.erase(it) : std::next(it);
  }
  if (playhead_ != before) {
    if (const auto it = finished_.find(before); it != finished_.end()) it->second.passed = true;
    if (const auto it = finished_.find(playhead_); it != finished_.end() && it->second.frame)
      reused_ += it->second.passed;
  }
  trim();
  if (!keep_newest_passed)
    passed_ = nullptr;
  else if (passed)
    passed_ = std::move(passed);
  store_.forgive(forgiven);
  store_.shrink(options_.store_bytes, [this](std::uint32_t f) -> std::uint64_t {
    return in_fetch_window(f) ? 0 : distance(f);
  });
}

/// Drops what lies outside the window and is beyond the budget, or failed.
void FrameBuffer::trim() {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> kept;  // distance, frame
  std::uint64_t bytes = 0;
  std::erase_if(finished_, [&](const auto& entry) {
    if (in_window(entry.first)) return false;
    if (!entry.second.frame || options_.cache_bytes == 0) return true;
    bytes += memory_of(*entry.second.frame);
    kept.emplace_back(distance(entry.first), entry.first);
    return false;
  });
  if (bytes <= options_.cache_bytes) return;
  std::sort(kept.rbegin(), kept.rend());
  for (const auto& [steps, frame] : kept) {
    if (bytes <= options_.cache_bytes) break;
    const auto it = finished_.find(frame);
    bytes -= memory_of(*it->second.frame);
    finished_.erase(it);
  }
}

/// Stops the making of frames for which `stale` says so. They may be made again at once.
template <class Stale>
void FrameBuffer::stop_making(Stale stale) {
  std::erase_if(making_, [&](auto& making) {
    if (!stale(making.first)) return false;
    making.second.stop.request_stop();
    return true;
  });
}

void FrameBuffer::advance(std::uint32_t frame, int direction) {
  {
    const std::lock_guard lock(mutex_);
    if (frame == playhead_ && direction == direction_ && !scrubbing_) return;
    scrubbing_ = false;
    move(frame, direction, true);
  }
  wake_all();
}

void FrameBuffer::seek(std::uint32_t frame, int direction) {
  {
    const std::lock_guard lock(mutex_);
    scrubbing_ = false;
    ++epoch_;
    move(frame, direction, false);
    store_.stop([this](std::uint32_t f) { return !in_fetch_window(f); });
    stop_making([this](std::uint32_t f) { return !in_window(f); });
  }
  wake_all();
}

void FrameBuffer::scrub(std::uint32_t frame) {
  {
    const std::lock_guard lock(mutex_);
    const std::uint32_t before = playhead_;
    if (!scrubbing_) {
      // The frame on the screen stays there. Frames ahead of it count as outside the window.
      if (const auto it = finished_.find(before); it != finished_.end() && it->second.frame)
        passed_ = it->second.frame;
      // Later on, what is being made is a base that shows where the cursor passed.
      stop_making([&](std::uint32_t f) { return f != before; });
      scrubbing_ = true;
      ++epoch_;
      passed_order_ = order_;
      trim();
    }
    if (frame != before) {
      dragged_back_ = frame < before;
      move(frame, direction_, true);
    }
    // If the frame under the cursor has to be fetched, it gets the whole link.
    const bool waits = store_.usable(playhead_, kBase) == 0 && !store_.coming(playhead_, kBase);
    store_.stop([&](std::uint32_t f) {
      return f != playhead_ && f != before && (waits || apart(f, playhead_) > options_.near);
    });
  }
  wake_all();
}

void FrameBuffer::set_loop(bool loop) {
  {
    const std::lock_guard lock(mutex_);
    options_.loop = loop;
    trim();
  }
  wake_all();
}

void FrameBuffer::set_loop_range(const std::optional<FrameRange>& range) {
  {
    const std::lock_guard lock(mutex_);
    if (range == loop_range_) return;
    loop_range_ = range;
    trim();
  }
  wake_all();
}

void FrameBuffer::make_again(DrawMode mode) {
  {
    const std::lock_guard lock(mutex_);
    options_.mode = mode;
    ++generation_;
    finished_.clear();
    making_.clear();
    passed_ = nullptr;
  }
  wake_all();
}

void FrameBuffer::set_level(int level) {
  {
    const std::lock_guard lock(mutex_);
    if (level == level_) return;
    level_ = level;
  }
  wake_all();
}

void FrameBuffer::set_pace(const Pace& pace) {
  {
    const std::lock_guard lock(mutex_);
    const std::uint32_t fetch_ahead =
        std::clamp(pace.fetch_ahead, options_.ahead, options_.frame_count - 1);
    const Pace before{fetch_ahead_, lead_, options_.base_first, focus_, coarse_first_};
    if (Pace{fetch_ahead, pace.lead, pace.base_first, pace.focus, pace.coarse_first} == before)
      return;
    fetch_ahead_ = fetch_ahead;
    lead_ = pace.lead;
    focus_ = pace.focus;
    coarse_first_ = pace.coarse_first;
    options_.base_first = pace.base_first;
  }
  wake_all();
}

// What is there.

std::shared_ptr<const SceneFrame> FrameBuffer::best() const {
  const std::lock_guard lock(mutex_);
  const auto it = finished_.find(playhead_);
  return it != finished_.end() && it->second.frame ? it->second.frame : passed_;
}

FrameBuffer::State FrameBuffer::wait(std::chrono::milliseconds timeout, bool fine) const {
  std::unique_lock lock(mutex_);
  const auto done = [&] {
    const auto it = finished_.find(playhead_);
    if (closed_ || it == finished_.end()) return closed_;
    return !fine || !it->second.frame || satisfied(playhead_);
  };
  if (!shown_changed_.wait_for(lock, timeout, done)) return State::waiting;
  if (closed_) return State::closed;
  return finished_.at(playhead_).frame ? State::ready : State::failed;
}

/// Whether a frame has been fetched, or is not to be had.
bool FrameBuffer::done_with(std::uint32_t frame) const {
  return finished_.contains(frame) || store_.limit(frame) == 0 || store_.usable(frame, kBase) > 0;
}

FrameBuffer::Fill FrameBuffer::fill() const {
  const std::lock_guard lock(mutex_);
  Fill fill;
  fill.full = !has_room();
  bool fetched = true, made = true;
  for (std::uint32_t step = 0; step <= std::max(fetch_ahead_, options_.ahead); ++step) {
    const auto frame = at(step);
    if (!frame) break;
    ++fill.window;
    if (fetched) fill.next = *frame;
    fetched = fetched && done_with(*frame);
    fill.fetched += fetched;
    if (step > options_.ahead) continue;
    ++fill.ahead;
    made = made && finished_.contains(*frame);
    fill.made += made;
  }
  return fill;
}

std::vector<BufferedRange> FrameBuffer::buffered() const {
  std::vector<BufferedRange> ranges;
  const auto add = [&](std::uint32_t frame, std::uint32_t layers) {
    if (!ranges.empty() && ranges.back().last + 1 == frame && ranges.back().layers == layers)
      ranges.back().last = frame;
    else
      ranges.push_back({frame, frame, layers});
  };
  const std::lock_guard lock(mutex_);
  auto made = finished_.begin();
  const auto layers_made = [](const Finished& finished) {
    return finished.frame ? std::max(1u, finished.frame->layers) : 0u;
  };
  const auto add_made_before = [&](std::uint32_t frame) {
    for (; made != finished_.end() && made->first < frame; ++made)
      if (made->second.frame) add(made->first, layers_made(made->second));
  };
  store_.for_each([&](std::uint32_t frame, std::uint32_t layers) {
    add_made_before(frame);
    if (made != finished_.end() && made->first == frame)
      layers = std::max(layers, layers_made((made++)->second));
    add(frame, layers);
  });
  add_made_before(options_.frame_count);
  return ranges;
}

void FrameBuffer::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    store_.stop([](std::uint32_t) { return true; });
    stop_making([](std::uint32_t) { return true; });
  }
  wake_all();
}

std::size_t FrameBuffer::held() const {
  const std::lock_guard lock(mutex_);
  return static_cast<std::size_t>(
             std::count_if(finished_.begin(), finished_.end(),
                           [](const auto& entry) { return entry.second.frame != nullptr; })) +
         (passed_ ? 1 : 0);
}

std::uint64_t FrameBuffer::held_bytes() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t bytes = passed_ ? memory_of(*passed_) : 0;
  for (const auto& [index, finished] : finished_)
    if (finished.frame && finished.frame != passed_) bytes += memory_of(*finished.frame);
  return bytes;
}

std::optional<FetchedFrame> FrameBuffer::stored_base(std::uint32_t frame, bool colors,
                                                     bool normals) const {
  const std::lock_guard lock(mutex_);
  if (store_.usable(frame, {0, 1, colors, normals}) == 0) return std::nullopt;
  return store_.get(frame, 1);
}

std::uint64_t FrameBuffer::stored_bytes() const {
  const std::lock_guard lock(mutex_);
  return store_.bytes();
}

std::uint64_t FrameBuffer::reused() const {
  const std::lock_guard lock(mutex_);
  return reused_;
}

}  // namespace pointreel
