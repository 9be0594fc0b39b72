#include "client/playback/buffer.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace pointreel {
namespace {

/// What is nearer than this is made of whatever is there; what is further may wait for what comes.
constexpr std::uint32_t kSoon = 2;
constexpr LayerRange kBase{0, 1, false, false};
/// At once, while scrubbing: one waits for the link's delay while another comes. With four, what is
/// on its way when the cursor jumps held up what it jumped to.
constexpr std::size_t kBesideCursor = 2;

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
  playhead_ = std::min(frame, options_.frame_count - 1);
  direction_ = direction < 0 ? -1 : 1;
  ++order_;
  // Of the frames that the playhead left behind, the one nearest to it is kept for as long as
  // nothing newer is there. Where the window is all that is played, they are in it still.
  const std::uint32_t moved = order_before.steps(before, playhead_).value_or(0);
  std::int64_t newest = -1;
  std::shared_ptr<const SceneFrame> passed;
  for (auto it = finished_.begin(); it != finished_.end();) {
    const std::uint32_t from = order_before.steps(before, it->first).value_or(0);
    const bool stays = in_window(it->first);
    // Of frames that were ahead and that a turn around has put behind, none was shown.
    const bool was_passed =
        (direction_ == direction_before || from == 0) && (!stays || from < moved);
    if (it->second.frame && was_passed && from > newest) {
      newest = from;
      passed = it->second.frame;
    }
    it = stays ? std::next(it) : finished_.erase(it);
  }
  if (!keep_newest_passed)
    passed_ = nullptr;
  else if (passed)
    passed_ = std::move(passed);
  store_.forgive([this](std::uint32_t f) { return !in_fetch_window(f); });
  store_.shrink(options_.store_bytes, [this](std::uint32_t f) -> std::uint64_t {
    return in_fetch_window(f) ? 0 : distance(f);
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
  }
  wake_all();
}

void FrameBuffer::scrub(std::uint32_t frame) {
  {
    const std::lock_guard lock(mutex_);
    const std::uint32_t before = playhead_;
    if (!scrubbing_) {
      // What is on the screen stays there; what lies ahead of it is not shown.
      if (const auto it = finished_.find(before); it != finished_.end() && it->second.frame)
        passed_ = it->second.frame;
      std::erase_if(finished_, [&](const auto& entry) { return entry.first != before; });
      scrubbing_ = true;
      ++epoch_;
      passed_order_ = order_;
    }
    if (frame != before) {
      dragged_back_ = frame < before;
      move(frame, direction_, true);
    }
    // What has to be fetched gets the whole link.
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
    order_changed();
  }
  wake_all();
}

void FrameBuffer::set_loop_range(const std::optional<FrameRange>& range) {
  {
    const std::lock_guard lock(mutex_);
    if (range == loop_range_) return;
    loop_range_ = range;
    order_changed();
  }
  wake_all();
}

void FrameBuffer::order_changed() {
  std::erase_if(finished_, [&](const auto& entry) { return !in_window(entry.first); });
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

// What is wanted.

LayerRange FrameBuffer::wanted(std::uint32_t frame) const {
  LayerRange wanted = options_.choice(frame, options_.mode, level_);
  const auto all = static_cast<std::uint32_t>(options_.levels.size());
  std::uint32_t seen = 1;
  while (seen < all && options_.levels[seen - 1] < level_) ++seen;
  wanted.end = scrubbing_ ? 1 : std::clamp(wanted.end, 1u, seen);
  return wanted;
}

/// The level that can be seen of a frame that is made of so many layers.
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

/// True if nothing that could be fetched would make it finer.
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

/// The nearest base that is neither there nor coming, once the cursor's own is there: where the
/// cursor is going first, then where it came from.
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
    // Those that have their base wait until there is nothing else.
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
    // Broken beyond what is known of it here: the playhead has come back to it, or it was given up
    // before it came into the window.
    if (!again && store_.limit(*frame) == 0) {
      finished_[*frame];
      tell_ready();
    }
    return std::nullopt;
  }
  const auto making = making_.find(*frame);
  // Other threads make the rest at the same time.
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
  // Which of the two is shown first is open.
  request.fetch_ms = coarse ? store_.fetch_ms(*frame) : store_.take_fetch_ms(*frame);
  request.wanted = want;
  return request;
}

std::optional<FrameRequest> FrameBuffer::find_wanted() {
  const std::uint32_t last = scrubbing_ || focused() ? 0 : options_.ahead;
  for (const bool again : {false, true})
    for (std::uint32_t step = 0; step <= last; ++step) {
      // Whoever looks at one frame may jump to another at any time: a thread is free for that one.
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
  if (it != making_.end() && --it->second.threads <= 0) making_.erase(it);
}

void FrameBuffer::deliver(const FrameRequest& request, std::shared_ptr<const SceneFrame> frame) {
  {
    const std::lock_guard lock(mutex_);
    answered(request);
    if (outdated(request)) {
      // Better than nothing, for who changes the rules faster than frames are made by them.
      if (request.mode != options_.mode || request.frame != playhead_ || request.epoch != epoch_)
        return;
      passed_ = std::move(frame);
    } else if (in_window(request.frame)) {
      Finished& finished = finished_[request.frame];
      const int level = std::min(request.level, options_.levels[request.layers - 1]);
      // Two threads may have made it, each of what was there at its time.
      if (!finished.frame || finished.frame->level <= frame->level) {
        finished.frame = std::move(frame);
        finished.made_of = request.wanted;
      }
      finished.tried = std::max(finished.tried, level);
      if (focus_ && satisfied(playhead_)) {
        to_fetch_.notify_all();
        to_make_.notify_all();
      }
      // What is cheap to fetch again is not kept.
      if (options_.store_bytes == 0 && satisfied(request.frame))
        store_.shrink(0, [&](std::uint32_t f) -> std::uint64_t { return f == request.frame; });
    } else if (request.epoch == epoch_) {
      if (scrubbing_) {
        if (request.order > passed_order_) {
          passed_order_ = request.order;
          passed_ = std::move(frame);
        }
      } else if (!passed_ || behind(request.frame) < behind(passed_->index)) {
        // Late. Of two late frames the one that lies less far behind is the newer.
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
      finished_[request.frame];  // what is there already stays
  }
  wake_all();
  tell_ready();
  return again;
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

/// Fetched, or not to be had.
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

}  // namespace pointreel
