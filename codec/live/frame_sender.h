#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "codec/live/live.h"
#include "codec/live/outbox.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"
#include "pointreel/package.h"

namespace pointreel {

/// Sends encoded frames to a server as a live stream (PROTOCOL.md, "Live"), in the order of the
/// calls, which come one at a time. Before the first frame, and whenever a frame changes what is
/// said of the stream, it sends that.
class FrameSender {
 public:
  FrameSender(OutboxOptions options, const ReelHead& head, LiveIdentity identity = {});

  /// What a frame adds to what is said of the stream.
  struct Content {
    Box box;  ///< of its points
    bool colors = false, normals = false;
    std::vector<ScalarRange> scalars = {};
  };
  /// Does not wait for the link. `capture_us`: Unix time. Where it does not rise, as by a clock
  /// that was set back, the stream's time goes on at the nominal rate.
  void send(EncodedFrame frame, const Content& content, std::uint64_t capture_us);

  /// A packet of Opus (live_sound.h). May be called by another thread than send().
  void send_sound(ByteView packet, std::uint16_t samples, std::uint64_t capture_us);

  std::uint32_t sent() const { return number_; }
  /// Gives what was sent last some time to arrive, more over a link that works.
  void flush();
  Outbox& outbox() { return outbox_; }
  const Outbox& outbox() const { return outbox_; }

 private:
  void greet(const Content& content);
  std::uint64_t time_of(std::uint64_t capture_us) const;

  const LiveIdentity identity_;
  LiveHello hello_;
  bool greeted_ = false;
  std::uint32_t number_ = 0;
  std::uint64_t last_us_ = 0;   ///< the time of the newest frame
  std::uint64_t shift_us_ = 0;  ///< from the times given to those of the stream
  std::uint32_t sounds_ = 0;
  Outbox outbox_;
};

/// Checks the address that a stream is published to, as in ws://HOST:8090/live/NAME, and adds what
/// tells publishers from viewers. Error: `argument`.
Result<std::string> publishing_address(const std::string& url);
/// The stream's name in such an address.
std::string stream_name_of(const std::string& url);

}  // namespace pointreel
