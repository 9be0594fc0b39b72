#include "server/publish/frame_input.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <poll.h>
#include <sys/inotify.h>
#include <unistd.h>

#include "common/base/bounded_queue.h"
#include "common/base/natural_order.h"
#include "common/base/unix_time.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

/// How long a wait for a descriptor goes on after it was stopped, at most.
constexpr int kPollMs = 50;
constexpr std::size_t kReadAhead = 3;
constexpr std::size_t kPieceSize = 1u << 20;

std::string what_went_wrong() { return std::generic_category().message(errno); }

/// The error without the file's name, which it begins with.
Result<LoadedCloud> read_file(const fs::path& file) {
  Result<LoadedCloud> cloud = read_cloud_file(file);
  const std::string place = file.string() + ": ";
  if (!cloud && cloud.error().message.starts_with(place)) {
    cloud.error().message.erase(0, place.size());
  }
  return cloud;
}

/// Waits until a descriptor can be read. False if it was stopped or failed.
bool wait_for(int descriptor, const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    pollfd waiting{descriptor, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, kPollMs);
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
  return false;
}

class FilePlayer : public FrameInput {
 public:
  FilePlayer(std::vector<fs::path> files, double fps, bool loop, LiveClock clock)
      : files_(std::move(files)), fps_(fps), loop_(loop), clock_(std::move(clock)) {}
  ~FilePlayer() override { ahead_.close(); }

  Result<std::optional<InputFrame>> next(const std::stop_token& stop) override {
    if (!reader_.joinable()) reader_ = std::jthread([this](std::stop_token s) { read(s); });
    const std::stop_callback closing(stop, [this] { ahead_.close(); });
    std::optional<InputFrame> frame = ahead_.pop();
    // Of frames whose time has come the newest is the one to publish.
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
    return begun_us_ +
           static_cast<std::uint64_t>(std::llround(static_cast<double>(frame) * 1e6 / fps_));
  }

  void read(const std::stop_token& stop) {
    for (std::uint64_t i = 0; !stop.stop_requested(); ++i) {
      if (i > 0) {
        // Who cannot read that fast goes on with the next one whose time is to come.
        const std::uint64_t now = clock_.now_us();
        while (due(i) + period_us() < now && (loop_ || i + 1 < files_.size())) {
          ++i;
          ++skipped_;
        }
      }
      if (!loop_ && i >= files_.size()) break;
      const fs::path& file = files_[i % files_.size()];
      Result<LoadedCloud> cloud = read_file(file);
      if (i == 0) begun_us_ = clock_.now_us();
      if (!ahead_.push({file.string(), due(i), std::move(cloud)})) return;
    }
    ahead_.close();
  }

  const std::vector<fs::path> files_;
  const double fps_;
  const bool loop_;
  const LiveClock clock_;
  BoundedQueue<InputFrame> ahead_{kReadAhead};
  std::uint64_t begun_us_ = 0;  ///< of the reader
  std::atomic<std::uint64_t> skipped_ = 0;
  std::jthread reader_;
};

bool is_cloud_name(std::string_view name) {
  return !name.starts_with('.') && (name.ends_with(".ply") || name.ends_with(".drc"));
}

class FolderFollower : public FrameInput {
 public:
  FolderFollower(fs::path folder, int watch, LiveClock clock)
      : folder_(std::move(folder)), watch_(watch), clock_(std::move(clock)) {
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_, ignored)) {
      const std::string name = entry.path().filename().string();
      if (is_cloud_name(name) && (newest_.empty() || natural_less(newest_, name))) newest_ = name;
    }
  }
  ~FolderFollower() override { ::close(watch_); }

  Result<std::optional<InputFrame>> next(const std::stop_token& stop) override {
    for (;;) {
      look();
      if (!newest_.empty()) break;
      if (!wait_for(watch_, stop)) return std::optional<InputFrame>();
    }
    const fs::path file = folder_ / std::exchange(newest_, {});
    const std::uint64_t now = clock_.now_us();
    return InputFrame{file.string(), now, read_file(file)};
  }

  std::uint64_t skipped() const override { return skipped_; }

 private:
  /// Takes what the system has to tell, without waiting.
  void look() {
    alignas(inotify_event) std::array<char, 16 * 1024> events;
    for (;;) {
      const ssize_t size = ::read(watch_, events.data(), events.size());
      if (size <= 0) return;
      for (ssize_t at = 0; at < size;) {
        const auto* event = reinterpret_cast<const inotify_event*>(events.data() + at);
        at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
        const std::string name = event->len > 0 ? event->name : "";
        if (!is_cloud_name(name)) continue;
        if (!newest_.empty() && newest_ != name) ++skipped_;
        newest_ = name;
      }
    }
  }

  const fs::path folder_;
  const int watch_;
  const LiveClock clock_;
  std::string newest_;  ///< not taken yet
  std::uint64_t skipped_ = 0;
};

class PipeReader : public FrameInput {
 public:
  PipeReader(int descriptor, LiveClock clock) : descriptor_(descriptor), clock_(std::move(clock)) {}

  Result<std::optional<InputFrame>> next(const std::stop_token& stop) override {
    if (!reader_.joinable()) reader_ = std::jthread([this](std::stop_token s) { read(s); });
    const std::stop_callback waking(stop, [this] { changed_.notify_all(); });
    std::unique_lock lock(mutex_);
    // Timed, for a stop may come between the look at it and the wait.
    while (!newest_ && !over_ && !stop.stop_requested()) {
      changed_.wait_for(lock, std::chrono::milliseconds(kPollMs));
    }
    if (newest_ && !stop.stop_requested()) {
      const Raw raw = *std::exchange(newest_, std::nullopt);
      lock.unlock();
      return InputFrame{fmt::format("frame {} of standard input", raw.number), raw.capture_us,
                        read_cloud(raw.bytes)};
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
    for (std::uint64_t number = 0; !error; ++number) {
      Result<std::optional<Bytes>> bytes = read_frame(stop, number);
      if (!bytes) {
        error = bytes.error();
        break;
      }
      if (!*bytes) break;
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

  /// Nothing at the end of the input.
  Result<std::optional<Bytes>> read_frame(const std::stop_token& stop, std::uint64_t number) {
    Bytes head;
    if (Result<bool> whole = read_bytes(head, 4, stop); !whole || !*whole) {
      if (!whole) return tl::unexpected(whole.error());
      if (head.empty() || stop.stop_requested()) return std::optional<Bytes>();
      return fail(fmt::format("standard input ends within the size of frame {}", number));
    }
    std::uint32_t size = 0;
    std::memcpy(&size, head.data(), sizeof(size));
    if (std::memcmp(head.data(), "ply", 3) == 0) {
      return fail("standard input is PLY: before each file its size must come, in four bytes");
    }
    if (size > kMaxInputFrame) {
      return fail(fmt::format("frame {} of standard input has {} bytes; {} are the most", number,
                              size, kMaxInputFrame));
    }
    Bytes bytes;
    const Result<bool> whole = read_bytes(bytes, size, stop);
    if (!whole) return tl::unexpected(whole.error());
    if (*whole) return bytes;
    if (stop.stop_requested()) return std::optional<Bytes>();
    return fail(fmt::format("standard input ends within frame {}", number));
  }

  /// False if the input ends before, or it is stopped.
  Result<bool> read_bytes(Bytes& bytes, std::size_t size, const std::stop_token& stop) const {
    while (bytes.size() < size) {
      if (!wait_for(descriptor_, stop)) return false;
      const std::size_t before = bytes.size();
      const std::size_t piece = std::min(size - before, std::max(kPieceSize, before));
      bytes.resize(before + piece);
      const ssize_t got = ::read(descriptor_, bytes.data() + before, piece);
      bytes.resize(before + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
      if (got == 0) return false;
      if (got < 0 && errno != EINTR && errno != EAGAIN) {
        return fail("standard input cannot be read: " + what_went_wrong());
      }
    }
    return true;
  }

  const int descriptor_;
  const LiveClock clock_;
  std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  std::optional<Raw> newest_;
  std::optional<Error> error_;
  bool over_ = false;
  std::atomic<std::uint64_t> skipped_ = 0;
  std::jthread reader_;
};

}  // namespace

LiveClock LiveClock::system() {
  using std::chrono::microseconds;
  using Clock = std::chrono::system_clock;
  LiveClock clock;
  clock.now_us = unix_time_us;
  clock.wait_until = [](std::uint64_t time_us, const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any stopped;
    std::unique_lock lock(mutex);
    const Clock::time_point time{microseconds(static_cast<std::int64_t>(time_us))};
    stopped.wait_until(lock, stop, time, [] { return false; });
  };
  return clock;
}

std::unique_ptr<FrameInput> play_files(std::vector<fs::path> files, double fps, bool loop,
                                       LiveClock clock) {
  return std::make_unique<FilePlayer>(std::move(files), fps, loop, std::move(clock));
}

Result<std::unique_ptr<FrameInput>> follow_folder(const fs::path& folder, LiveClock clock) {
  const int watch = ::inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  if (watch < 0 ||
      ::inotify_add_watch(watch, folder.c_str(), IN_CLOSE_WRITE | IN_MOVED_TO | IN_ONLYDIR) < 0) {
    const std::string what = what_went_wrong();
    if (watch >= 0) ::close(watch);
    return fail(fmt::format("{}: cannot be followed: {}", folder.string(), what));
  }
  return std::make_unique<FolderFollower>(folder, watch, std::move(clock));
}

std::unique_ptr<FrameInput> read_pipe(int descriptor, LiveClock clock) {
  return std::make_unique<PipeReader>(descriptor, std::move(clock));
}

}  // namespace pointreel
