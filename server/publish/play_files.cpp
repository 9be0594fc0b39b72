#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <span>
#include <thread>
#include <utility>

#include "common/base/unix_time.h"
#include "common/threads/bounded_queue.h"
#include "server/publish/frame_input.h"

namespace pointreel {
namespace {

constexpr std::size_t kReadAhead = 3;  // frames

class FilePlayer : public FrameInput {
 public:
  FilePlayer(CloudSequence sequence, double fps, bool loop, LiveClock clock,
             std::uint64_t max_memory)
      : sequence_(std::move(sequence)),
        files_(sequence_.frames),
        fps_(sequence_.times_us.empty() ? fps : sequence_.fps),
        loop_(loop),
        clock_(std::move(clock)),
        max_memory_(max_memory) {}
  ~FilePlayer() override { ahead_.close(); }

  Result<std::optional<InputFrame>> next(const std::stop_token& stop) override {
    if (!reader_.joinable()) reader_ = std::jthread([this](std::stop_token s) { read(s); });
    const std::stop_callback closing(stop, [this] { ahead_.close(); });
    std::optional<InputFrame> frame = ahead_.pop();
    // If several frames are due, the newest of them is published.
    while (frame && !stop.stop_requested() && ahead_.size() > 0 &&
           frame->capture_us + period_us() <= clock_.now_us()) {
      frame = ahead_.pop();
      ++skipped_;
    }
    if (!frame || stop.stop_requested()) return std::optional<InputFrame>();
    clock_.wait_until(frame->capture_us, stop);
    return frame;
  }

  std::uint64_t skipped() const override { return skipped_; }

 private:
  std::uint64_t period_us() const { return static_cast<std::uint64_t>(1e6 / fps_); }
  std::uint64_t due(std::uint64_t frame) const {
    if (!sequence_.times_us.empty()) {
      const std::uint64_t round = frame / files_.size();
      return begun_us_ + round * sequence_.end_us() + sequence_.times_us[frame % files_.size()];
    }
    return begun_us_ +
           static_cast<std::uint64_t>(std::llround(static_cast<double>(frame) * 1e6 / fps_));
  }

  void read(const std::stop_token& stop) {
    for (std::uint64_t i = 0; !stop.stop_requested(); ++i) {
      if (i > 0) {
        // If reading is too slow, it continues with the next frame that is not yet due.
        const std::uint64_t now = clock_.now_us();
        while (due(i) + period_us() < now && (loop_ || i + 1 < files_.size())) {
          ++i;
          ++skipped_;
        }
      }
      if (!loop_ && i >= files_.size()) break;
      const CloudFrame& frame = files_[i % files_.size()];
      Result<LoadedCloud> cloud = read_cloud_frame(frame, {.max_memory = max_memory_});
      if (i == 0) begun_us_ = clock_.now_us();
      if (!ahead_.push({frame.name(), due(i), std::move(cloud)})) return;
    }
    ahead_.close();
  }

  const CloudSequence sequence_;
  const std::span<const CloudFrame> files_;
  const double fps_;
  const bool loop_;
  const LiveClock clock_;
  const std::uint64_t max_memory_;
  BoundedQueue<InputFrame> ahead_{kReadAhead};
  std::uint64_t begun_us_ = 0;  ///< used by the reader thread only
  std::atomic<std::uint64_t> skipped_ = 0;
  std::jthread reader_;
};

}  // namespace

LiveClock LiveClock::system() {
  LiveClock clock;
  clock.now_us = unix_time_us;
  clock.wait_until = [](std::uint64_t time_us, const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any stopped;
    std::unique_lock lock(mutex);
    const std::uint64_t now = unix_time_us();
    if (time_us <= now) return;
    const std::chrono::microseconds left(static_cast<std::int64_t>(time_us - now));
    stopped.wait_for(lock, stop, left, [] { return false; });
  };
  return clock;
}

std::unique_ptr<FrameInput> play_files(CloudSequence sequence, double fps, bool loop,
                                       LiveClock clock, std::uint64_t max_memory) {
  return std::make_unique<FilePlayer>(std::move(sequence), fps, loop, std::move(clock), max_memory);
}

}  // namespace pointreel
