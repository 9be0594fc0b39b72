#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "codec/live/frame_sender.h"
#include "codec/live/kept_identity.h"
#include "codec/package/encoding_options.h"
#include "codec/package/steady_grid.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// Publishes clouds in memory as a live stream. To be used by one thread at a time.
class FramePublisher {
 public:
  /// `url`: ws(s)://HOST/live/NAME. Waits until the first attempt to connect has ended; a server
  /// that does not answer yet is tried again later. An empty `options.name` stands for that of the
  /// stream. Errors: `argument`; `io` or what else the server refuses the publisher for.
  static Result<std::unique_ptr<FramePublisher>> open(const std::string& url,
                                                      const std::string& token,
                                                      const std::string& ca_file,
                                                      const EncodingOptions& options,
                                                      const std::stop_token& stop);

  /// Encodes a frame and hands it to the thread that sends. `capture_us`: Unix time; by default
  /// now. Where the link is too slow, frames and fine layers are left out. An error if the frame
  /// cannot be encoded, if its time is none of a clock that is right, or if the server has refused
  /// the publisher for good.
  Result<void> send(const PointCloud& cloud, std::optional<std::uint64_t> capture_us);

  /// Gives what was sent last some time to arrive.
  void flush() { sender_.flush(); }
  /// Why nothing can be sent at present; empty if nothing is known to be wrong.
  std::string trouble() const { return sender_.outbox().trouble(); }
  std::uint32_t sent() const { return sender_.sent(); }
  /// How many frames the server has accepted.
  std::uint64_t accepted() const { return sender_.outbox().statistics().accepted_frames; }

 private:
  FramePublisher(OutboxOptions outbox, const EncodingOptions& options);

  const EncodingOptions options_;
  const KeptIdentity identity_;
  SteadyGrid grid_;
  FrameSender sender_;
};

}  // namespace pointreel
