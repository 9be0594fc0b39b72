#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include "common/base/try.h"
#include "common/file_system/descriptor.h"
#include "server/publish/frame_input.h"

namespace pointreel {
namespace {

/// Memory is first taken for this many bytes of a frame, and then for twice as many as have
/// arrived.
constexpr std::size_t kFirstPiece = 1u << 20;

class PipeReader : public FrameInput {
 public:
  PipeReader(int descriptor, LiveClock clock, Reading asked, std::uint64_t max_memory)
      : descriptor_(descriptor),
        clock_(std::move(clock)),
        reading_(std::move(asked)),
        max_memory_(max_memory) {}

  Result<std::optional<InputFrame>> next(const std::stop_token& stop) override {
    if (!reader_.joinable()) reader_ = std::jthread([this](std::stop_token s) { read(s); });
    std::unique_lock lock(mutex_);
    changed_.wait(lock, stop, [&] { return newest_ || over_; });
    if (newest_ && !stop.stop_requested()) {
      const Raw raw = *std::exchange(newest_, std::nullopt);
      lock.unlock();
      InputFrame frame{fmt::format("frame {} of standard input", raw.number), raw.capture_us,
                       read_cloud(raw.bytes, {.max_memory = max_memory_}, reading_)};
      if (!frame.cloud) {
        frame.cloud = fail_at(frame.name, frame.cloud.error());
      } else if (reading_.full_color == 0.0) {
        reading_.full_color = frame.cloud->full_color;
      }
      return frame;
    }
    if (error_) return tl::unexpected(*error_);
    return std::optional<InputFrame>();
  }

  std::uint64_t skipped() const override { return skipped_; }

 private:
  struct Raw {
    std::uint64_t number = 0, capture_us = 0;
    Bytes bytes;
  };

  void read(const std::stop_token& stop) {
    std::optional<Error> error;
    for (std::uint64_t number = 0;; ++number) {
      Result<std::optional<Bytes>> bytes = read_frame(stop, number);
      if (!bytes) error = bytes.error();
      if (!bytes || !*bytes) break;
      const std::lock_guard lock(mutex_);
      if (newest_) ++skipped_;
      newest_ = Raw{number, clock_.now_us(), std::move(**bytes)};
      changed_.notify_all();
    }
    const std::lock_guard lock(mutex_);
    error_ = std::move(error);
    over_ = true;
    changed_.notify_all();
  }

  /// Nothing at the end of the input, or if it was stopped.
  Result<std::optional<Bytes>> read_frame(const std::stop_token& stop, std::uint64_t number) {
    Bytes head;
    if (!TRY(read_bytes(head, 4, stop))) {
      if (head.empty() || stop.stop_requested()) return std::optional<Bytes>();
      return fail(fmt::format("standard input ends within the size of frame {}", number));
    }
    std::uint32_t size = 0;
    std::memcpy(&size, head.data(), sizeof(size));
    if (std::memcmp(head.data(), "ply", 3) == 0) {
      return fail("standard input is PLY: its size must come before each file, in four bytes");
    }
    if (size > kMaxInputFrame) {
      return fail(ErrorCode::limit,
                  fmt::format("frame {} of standard input has {} bytes; at most {} are allowed",
                              number, size, kMaxInputFrame));
    }
    Bytes bytes;
    if (TRY(read_bytes(bytes, size, stop))) return bytes;
    if (stop.stop_requested()) return std::optional<Bytes>();
    return fail(fmt::format("standard input ends within frame {}", number));
  }

  /// False if the input ends before that, or if it was stopped.
  Result<bool> read_bytes(Bytes& bytes, std::size_t size, const std::stop_token& stop) const {
    while (bytes.size() < size) {
      if (!wait_readable(descriptor_, stop)) return false;
      const std::size_t before = bytes.size();
      const std::size_t piece = std::min(size - before, std::max(kFirstPiece, before));
      bytes.resize(before + piece);
      const ssize_t got = ::read(descriptor_, bytes.data() + before, piece);
      bytes.resize(before + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
      if (got == 0) return false;
      if (got < 0 && errno != EINTR && errno != EAGAIN) {
        return fail(ErrorCode::io, "standard input cannot be read: " + errno_message());
      }
    }
    return true;
  }

  const int descriptor_;
  const LiveClock clock_;
  Reading reading_;
  const std::uint64_t max_memory_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable_any changed_;
  std::optional<Raw> newest_;
  std::optional<Error> error_;
  bool over_ = false;
  std::atomic<std::uint64_t> skipped_ = 0;
  std::jthread reader_;
};

}  // namespace

std::unique_ptr<FrameInput> read_pipe(int descriptor, LiveClock clock, Reading asked,
                                      std::uint64_t max_memory) {
  return std::make_unique<PipeReader>(descriptor, std::move(clock), std::move(asked), max_memory);
}

}  // namespace pointreel
