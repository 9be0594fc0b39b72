#include "client/bindings/frames/read_ahead.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "common/threads/without_exceptions.h"

namespace pointreel {
namespace {

/// One fetches while another decodes, with all processors.
constexpr std::size_t kMostThreads = 2;

}  // namespace

ReadAhead::ReadAhead(std::shared_ptr<const ReelFrames> reel, std::vector<std::uint32_t> order,
                     const ReadLimits& limits, std::size_t ahead)
    : reel_(std::move(reel)), order_(std::move(order)), limits_(limits), ahead_(ahead) {
  outer_stop_.emplace(limits.stop, [this] { stop_.request_stop(); });
  limits_.stop = stop_.get_token();
  const std::size_t threads = std::min({kMostThreads, ahead_, order_.size()});
  try {
    for (std::size_t i = 0; i < threads; ++i) threads_.emplace_back([this] { read(); });
  } catch (...) {
    end();  // the threads that there are must not wait to be asked for frames any more
    throw;
  }
}

ReadAhead::~ReadAhead() { end(); }

void ReadAhead::end() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  outer_stop_.reset();
  stop_.request_stop();
}

bool ReadAhead::ended() const {
  const std::lock_guard lock(mutex_);
  return taken_ == order_.size();
}

std::optional<Result<SharedFrame>> ReadAhead::next(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout,
                    [&] { return taken_ == order_.size() || read_.contains(taken_); });
  if (!read_.contains(taken_)) return std::nullopt;
  auto frame = std::move(read_.extract(taken_++).mapped());
  lock.unlock();
  changed_.notify_all();
  return frame;
}

void ReadAhead::read() {
  std::unique_lock lock(mutex_);
  for (;;) {
    const auto may_begin = [&] {
      return ending_ || begun_ == order_.size() || begun_ < taken_ + ahead_;
    };
    changed_.wait(lock, may_begin);
    if (ending_ || begun_ == order_.size()) return;
    const std::size_t place = begun_++;
    lock.unlock();
    auto frame = without_exceptions([&] { return reel_->read(order_[place], limits_); });
    lock.lock();
    read_.emplace(place, std::move(frame));
    changed_.notify_all();
  }
}

}  // namespace pointreel
