#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "client/playback/buffer.h"
#include "tests/wait.h"

namespace pointreel {

inline std::shared_ptr<const SceneFrame> picture(std::uint32_t index) {
  auto frame = std::make_shared<SceneFrame>();
  frame->index = index;
  return frame;
}

inline FrameBuffer::Options options(std::uint32_t frames, std::uint32_t ahead, bool loop) {
  FrameBuffer::Options options;
  options.frame_count = frames;
  options.ahead = ahead;
  options.loop = loop;
  return options;
}

/// The layers of a job as a source would deliver them, ten bytes each.
inline FetchedFrame layers_of(const FetchRequest& job) {
  FetchedFrame fetched;
  for (std::uint32_t i = job.layers.first; i < job.layers.end; ++i)
    fetched.layers.push_back({Bytes(10, static_cast<std::uint8_t>(job.frame)), {10, 0, 0}});
  return fetched;
}

/// Requests the next fetch in a thread of its own.
class Fetcher {
 public:
  explicit Fetcher(FrameBuffer& buffer)
      : thread_([this, &buffer] {
          job_ = buffer.next_fetch();
          answered_ = true;
        }) {}

  /// Whether the buffer keeps the request waiting because nothing is wanted.
  bool waits() const {
    return !wait_until([this] { return answered_.load(); }, kMoment);
  }
  /// Waits for the answer. There is none if the buffer was closed.
  std::optional<FetchRequest> job() {
    thread_.join();
    return job_;
  }

 private:
  std::optional<FetchRequest> job_;
  std::atomic<bool> answered_{false};
  std::thread thread_;  // last, since it uses the members above
};

/// Fetches the job that is wanted first. Returns the frame that is then to be made first.
inline FrameRequest ask(FrameBuffer& buffer) {
  const auto job = buffer.next_fetch();
  buffer.fetched(*job, layers_of(*job), 1.0);
  return *buffer.next_wanted();
}

/// Answers `count` requests and returns their frames.
inline std::vector<std::uint32_t> serve(FrameBuffer& buffer, int count) {
  std::vector<std::uint32_t> frames;
  for (int i = 0; i < count; ++i) {
    const auto request = ask(buffer);
    frames.push_back(request.frame);
    buffer.deliver(request, picture(request.frame));
  }
  return frames;
}

using Frames = std::vector<std::uint32_t>;

}  // namespace pointreel
