#include "client/playback/buffer.h"

#include <algorithm>
#include <utility>

namespace pointreel {

FrameBuffer::FrameBuffer(const Options& options) : options_(options) {
  options_.ahead = std::min(options_.ahead, options_.frame_count - 1);
}

std::uint32_t FrameBuffer::distance(std::uint32_t frame) const {
  const std::int64_t count = options_.frame_count;
  const std::int64_t steps =
      (static_cast<std::int64_t>(frame) - static_cast<std::int64_t>(playhead_)) * direction_;
  if (steps >= 0) return static_cast<std::uint32_t>(steps);
  return static_cast<std::uint32_t>(options_.loop ? steps + count : count - steps);
}

template <class Predicate>
std::optional<std::uint32_t> FrameBuffer::first_in_window(const Predicate& predicate) const {
  const std::int64_t count = options_.frame_count;
  for (std::int64_t step = 0; step <= options_.ahead && step < count; ++step) {
    std::int64_t frame = static_cast<std::int64_t>(playhead_) + step * direction_;
    if (frame < 0 || frame >= count) {
      if (!options_.loop) break;
      frame = (frame + count) % count;
    }
    const auto index = static_cast<std::uint32_t>(frame);
    if (!in_work_.contains(index) && predicate(index)) return index;
  }
  return std::nullopt;
}

std::optional<std::uint32_t> FrameBuffer::first_missing() const {
  const auto missing =
      first_in_window([this](std::uint32_t frame) { return !finished_.contains(frame); });
  if (missing) return missing;
  return first_in_window([this](std::uint32_t frame) {
    const auto it = finished_.find(frame);
    return it != finished_.end() && lacks_level(it->second);
  });
}

void FrameBuffer::move(std::uint32_t frame, bool keep_newest_passed) {
  const std::uint32_t before = playhead_;
  playhead_ = std::min(frame, options_.frame_count - 1);
  // Of the frames that the playhead left behind, the one nearest to it is kept for as long as
  // nothing newer is there.
  std::uint32_t newest = 0;
  std::shared_ptr<const SceneFrame> passed;
  for (auto it = finished_.begin(); it != finished_.end();) {
    if (in_window(it->first)) {
      ++it;
      continue;
    }
    const std::uint32_t from_before =
        options_.loop ? (it->first + options_.frame_count - before) % options_.frame_count
                      : it->first;
    if (it->second.frame && (!passed || from_before > newest)) {
      newest = from_before;
      passed = it->second.frame;
    }
    it = finished_.erase(it);
  }
  if (!keep_newest_passed)
    passed_ = nullptr;
  else if (passed)
    passed_ = std::move(passed);
}

void FrameBuffer::advance(std::uint32_t frame) {
  {
    const std::lock_guard lock(mutex_);
    if (frame == playhead_ && direction_ == 1) return;
    direction_ = 1;
    move(frame, true);
  }
  changed_.notify_all();
}

void FrameBuffer::seek(std::uint32_t frame, int direction) {
  {
    const std::lock_guard lock(mutex_);
    direction_ = direction < 0 ? -1 : 1;
    ++epoch_;
    move(frame, false);
  }
  changed_.notify_all();
}

void FrameBuffer::set_loop(bool loop) {
  {
    const std::lock_guard lock(mutex_);
    options_.loop = loop;
    std::erase_if(finished_, [&](const auto& entry) { return !in_window(entry.first); });
  }
  changed_.notify_all();
}

void FrameBuffer::set_mode(DrawMode mode) {
  {
    const std::lock_guard lock(mutex_);
    if (mode == options_.mode) return;
    options_.mode = mode;
    ++generation_;
    finished_.clear();
    in_work_.clear();
    passed_ = nullptr;
  }
  changed_.notify_all();
}

void FrameBuffer::set_level(int level) {
  {
    const std::lock_guard lock(mutex_);
    if (level == level_) return;
    level_ = level;
  }
  changed_.notify_all();
}

std::shared_ptr<const SceneFrame> FrameBuffer::best() const {
  const std::lock_guard lock(mutex_);
  const auto it = finished_.find(playhead_);
  return it != finished_.end() && it->second.frame ? it->second.frame : passed_;
}

FrameBuffer::State FrameBuffer::wait(std::chrono::milliseconds timeout, bool fine) const {
  std::unique_lock lock(mutex_);
  const auto done = [&] {
    const auto it = finished_.find(playhead_);
    return it != finished_.end() && !(fine && lacks_level(it->second));
  };
  changed_.wait_for(lock, timeout, [&] { return closed_ || done(); });
  if (closed_) return State::closed;
  if (!done()) return State::waiting;
  return finished_.at(playhead_).frame ? State::ready : State::failed;
}

void FrameBuffer::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  changed_.notify_all();
}

std::optional<FrameRequest> FrameBuffer::next_wanted() {
  std::unique_lock lock(mutex_);
  std::optional<std::uint32_t> frame;
  changed_.wait(lock, [&] { return closed_ || (frame = first_missing()); });
  if (closed_) return std::nullopt;
  ++in_work_[*frame];
  return FrameRequest{*frame, options_.mode, level_, epoch_, generation_};
}

bool FrameBuffer::wanted(const FrameRequest& request) const {
  const std::lock_guard lock(mutex_);
  if (closed_ || outdated(request)) return false;
  if (!in_window(request.frame)) return request.epoch == epoch_;
  const auto it = finished_.find(request.frame);
  return it == finished_.end() || (it->second.frame && it->second.frame->level < request.level);
}

bool FrameBuffer::late(const FrameRequest& request) const {
  const std::lock_guard lock(mutex_);
  return !in_window(request.frame);
}

void FrameBuffer::answered(const FrameRequest& request) {
  if (outdated(request)) return;
  const auto it = in_work_.find(request.frame);
  if (it != in_work_.end() && --it->second <= 0) in_work_.erase(it);
}

void FrameBuffer::deliver(const FrameRequest& request, std::shared_ptr<const SceneFrame> frame) {
  {
    const std::lock_guard lock(mutex_);
    answered(request);
    if (outdated(request)) return;
    if (in_window(request.frame)) {
      Finished& finished = finished_[request.frame];
      finished.tried = std::max(finished.tried, request.level);
      // Two threads may have made it, each for the view of its time.
      if (!finished.frame || finished.frame->level <= frame->level)
        finished.frame = std::move(frame);
    } else if (request.epoch == epoch_) {
      // Late. Of two late frames the one that lies less far behind is the newer.
      const std::uint32_t count = options_.frame_count;
      const auto behind = [&](std::uint32_t f) { return (playhead_ + count - f) % count; };
      if (!passed_ || behind(request.frame) < behind(passed_->index)) passed_ = std::move(frame);
    }
  }
  changed_.notify_all();
}

void FrameBuffer::fail(const FrameRequest& request) {
  {
    const std::lock_guard lock(mutex_);
    answered(request);
    if (!outdated(request) && in_window(request.frame)) {
      Finished& finished = finished_[request.frame];  // what is there already stays
      finished.tried = std::max(finished.tried, request.level);
    }
  }
  changed_.notify_all();
}

void FrameBuffer::abandon(const FrameRequest& request) {
  {
    const std::lock_guard lock(mutex_);
    answered(request);
  }
  changed_.notify_all();
}

std::size_t FrameBuffer::held() const {
  const std::lock_guard lock(mutex_);
  return static_cast<std::size_t>(
             std::count_if(finished_.begin(), finished_.end(),
                           [](const auto& entry) { return entry.second.frame != nullptr; })) +
         (passed_ ? 1 : 0);
}

}  // namespace pointreel
