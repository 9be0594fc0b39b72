#include "client/source/live_assembler.h"

#include <algorithm>
#include <utility>

namespace pointreel {

void LiveAssembler::add(LiveHello hello) {
  {
    const std::lock_guard lock(mutex_);
    frames_.add(std::move(hello));
  }
  changed_.notify_all();
}

void LiveAssembler::add(const LiveLayer& layer, SharedBytes bytes) {
  {
    const std::lock_guard lock(mutex_);
    frames_.add(layer, std::move(bytes), Clock::now());
  }
  changed_.notify_all();
}

void LiveAssembler::add_bad() {
  const std::lock_guard lock(mutex_);
  frames_.add_bad();
}

void LiveAssembler::set_dropped(std::uint64_t layers) {
  const std::lock_guard lock(mutex_);
  frames_.set_dropped(layers);
}

void LiveAssembler::reconnected() {
  {
    const std::lock_guard lock(mutex_);
    frames_.reconnected();
  }
  changed_.notify_all();
}

std::optional<LiveHello> LiveAssembler::hello(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout, [this] { return frames_.hello() || cancelled_; });
  return frames_.hello();
}

std::optional<LiveFrame> LiveAssembler::next(std::chrono::milliseconds timeout) {
  const auto deadline = Clock::now() + timeout;
  std::unique_lock lock(mutex_);
  while (!cancelled_) {
    const auto now = Clock::now();
    if (auto frame = frames_.next(now)) return frame;
    if (now >= deadline) return std::nullopt;
    changed_.wait_until(lock, std::min(deadline, frames_.due().value_or(deadline)));
  }
  return std::nullopt;
}

LiveCounts LiveAssembler::counts() const {
  const std::lock_guard lock(mutex_);
  return frames_.counts();
}

void LiveAssembler::cancel() {
  {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
  }
  changed_.notify_all();
}

}  // namespace pointreel
