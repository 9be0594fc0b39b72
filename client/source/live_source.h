#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "client/source/source.h"

namespace pointreel {

struct LiveHello;  // common/stream/live.h

/// The newest frame of a live stream, as much of it as came.
struct LiveFrame {
  std::uint32_t number = 0;
  std::uint64_t capture_us = 0;   ///< Unix time of the publisher's clock, microseconds
  FetchedFrame frame;             ///< a prefix of its layers, at least the base
  std::uint32_t layers_sent = 1;  ///< that the publisher made of it
};

/// What happened so far.
struct LiveCounts {
  std::uint64_t frames = 0;         ///< distinct frames that next() gave
  std::uint64_t skipped = 0;        ///< came with their base, but a newer one was there already
  std::uint64_t dropped = 0;        ///< layers that the server says it left out for this viewer
  std::uint64_t bad = 0;            ///< messages that were no layers of this stream
  std::uint64_t reconnections = 0;  ///< connections that were made after the first
  std::uint64_t bytes = 0;          ///< of layers
};

/// Frames as they are captured. Runs a thread that keeps the connection: what breaks is made again,
/// for as long as the object lives. All functions may be called from any thread.
///
/// Trust: messages may be hostile; live.h tells how they are read. What is kept is bounded: a few
/// frames, the newest ones.
class LiveSource {
 public:
  virtual ~LiveSource() = default;

  /// What the publisher says of its stream, waiting for it so long; none if it has said nothing
  /// yet. Of the newest publisher if it was started again.
  virtual std::optional<LiveHello> hello(std::chrono::milliseconds timeout) = 0;

  /// Waits for a frame newer than the last one given. It is given when all its layers have come, or
  /// when the next one begins, or, with fewer layers, when they are not coming; if they still come
  /// before the next frame, it is given again with more. Older frames are skipped. A publisher that
  /// was started again begins at any number.
  virtual std::optional<LiveFrame> next(std::chrono::milliseconds timeout) = 0;

  /// One line while nothing comes because the link or the publisher is not there.
  virtual std::optional<std::string> trouble() const = 0;
  virtual LiveCounts counts() const = 0;

  /// Ends the waits of hello() and next(), now and later.
  virtual void cancel() = 0;
};

}  // namespace pointreel
