#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "client/source/live_frames.h"
#include "client/source/source.h"
#include "codec/live/live_sound.h"

namespace pointreel {

/// How long before it is heard sound should have come: for the buffer of the sound card, for a
/// grain of AudioVoice, and for a round of the playback loop.
inline constexpr std::chrono::microseconds kSoundLead{110'000};

/// Frames as they are captured. A thread of its own keeps up the connection, and makes it again
/// whenever it breaks, for as long as the object lives. All functions may be called from any
/// thread.
///
/// Trust: messages may be hostile; live.h says how they are read. No more than the few newest
/// frames are kept.
class LiveSource {
 public:
  virtual ~LiveSource() = default;

  /// What the publisher says of its stream, waiting for it no longer than `timeout`; none if it has
  /// said nothing yet. If the publisher was started again, what it says now.
  virtual std::optional<LiveHello> hello(std::chrono::milliseconds timeout) = 0;

  /// Waits for a frame newer than the last one given. A frame is given when all its layers have
  /// come, when the next frame begins, or with fewer layers when the rest does not come for a
  /// while; if the rest comes after all before the next frame, the frame is given again with more
  /// layers. Older frames are skipped. A publisher that was started again begins at any number.
  virtual std::optional<LiveFrame> next(std::chrono::milliseconds timeout) = 0;

  /// Called with each packet of sound from now on, by the source's thread: it must not block. None
  /// comes without SourceOptions::sound.
  using OnSound = std::function<void(const LiveSound& sound)>;
  virtual void set_on_sound(OnSound on_sound) = 0;

  /// One line while nothing comes because the link or the publisher is down.
  virtual std::optional<std::string> trouble() const = 0;
  /// Why nothing will come, ever: the server refused this viewer before anything came, because of
  /// its token. The waits of hello() and next() have ended then.
  virtual std::optional<Error> refusal() const { return std::nullopt; }
  virtual LiveCounts counts() const = 0;

  /// Ends the waits of hello() and next(), now and later.
  virtual void cancel() = 0;
};

}  // namespace pointreel
