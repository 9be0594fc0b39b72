#include "client/record/audio_feed.h"

#include <algorithm>
#include <cerrno>
#include <utility>
#include <vector>

#include <sys/socket.h>
#include <unistd.h>

#include "codec/audio/audio_time.h"

namespace pointreel {
namespace {

/// ffmpeg may ask for so much sound before it takes another picture, and no more.
constexpr std::uint64_t kAheadUs = 5'000'000;
constexpr std::size_t kBlock = kAudioRate / 10;

}  // namespace

AudioFeed::AudioFeed(int socket, RecordedSound sound)
    : socket_(socket),
      sound_(std::move(sound)),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

AudioFeed::~AudioFeed() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  shutdown(socket_, SHUT_RDWR);
}

void AudioFeed::allow(std::uint64_t time_us) {
  const std::lock_guard lock(mutex_);
  allowed_ = std::max(allowed_, first_sample_from(sound_.end_us.value_or(time_us + kAheadUs)));
  changed_.notify_one();
}

Result<void> AudioFeed::finish(std::uint64_t end_us) {
  {
    const std::lock_guard lock(mutex_);
    allowed_ = first_sample_from(end_us);
    last_ = true;
    changed_.notify_one();
  }
  thread_.join();
  return result_;
}

void AudioFeed::run(const std::stop_token& stop) {
  std::vector<StereoSample> block(kBlock);
  std::uint64_t written = 0;
  for (;;) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, stop, [&] { return last_ || allowed_ > written; });
    if (stop.stop_requested() || allowed_ <= written) break;
    const auto next = std::span(block).first(std::min<std::uint64_t>(kBlock, allowed_ - written));
    lock.unlock();
    if (const Result<void> made = sound_.read(written, next); !made) {
      lock.lock();
      result_ = made;
      break;
    }
    if (!send(next)) break;
    written += next.size();
  }
  close(socket_);
}

bool AudioFeed::send(std::span<const StereoSample> samples) const {
  const char* at = reinterpret_cast<const char*>(samples.data());
  for (std::size_t size = samples.size_bytes(); size > 0;) {
    const ssize_t sent = ::send(socket_, at, size, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    at += sent;
    size -= static_cast<std::size_t>(sent);
  }
  return true;
}

}  // namespace pointreel
