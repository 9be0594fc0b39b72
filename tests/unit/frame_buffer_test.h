#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "client/playback/buffer.h"

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

/// The layers of a job as a source would give them, of ten bytes each.
inline FetchedFrame layers_of(const FetchJob& job) {
  FetchedFrame fetched;
  for (std::uint32_t i = job.first; i < job.last; ++i)
    fetched.layers.push_back({Bytes(10, static_cast<std::uint8_t>(job.frame)), {10, 0, 0}});
  return fetched;
}

/// Fetches what is wanted first and says what is to be made first then.
inline FrameRequest ask(FrameBuffer& buffer) {
  const auto job = buffer.next_fetch();
  buffer.fetched(*job, layers_of(*job), 1.0);
  return *buffer.next_wanted();
}

/// Answers `count` requests and says for which frames they were.
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
