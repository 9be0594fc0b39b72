#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "codec/live/outbox.h"
#include "codec/package/encoding_options.h"
#include "common/base/median.h"
#include "pointreel/error.h"
#include "server/publish/frame_input.h"

namespace pointreel {

/// What to publish, and where to. As many frames are encoded at the same time as there are threads.
/// Without `frame_time_ms`, they use 80 % of these threads' time.
struct PublishOptions : EncodingOptions {
  OutboxOptions outbox;
  std::string sound;        ///< as SoundSource::name; empty: silence
  bool loop_sound = false;  ///< SoundSource::loop
};

struct PublishListener {
  std::function<void(const std::string& line)> say;  ///< lines for people, one call at a time
  std::stop_token stop;
};

struct PublishSummary {
  std::uint64_t frames = 0;    ///< encoded
  std::uint64_t skipped = 0;   ///< arrived while all threads encoded others
  std::uint64_t unusable = 0;  ///< could not be read or encoded
  std::uint64_t late = 0;      ///< took longer than the frame time
  Spread encode_ms;            ///< of each frame, with cleaning
  int depth_min = 0, depth_max = 0;
  int lowered = 0;  ///< how often the depth was lowered because encoding took too long
  OutboxStatistics sent;
  std::string trouble;               ///< why nothing could be sent at the end; may be empty
  std::optional<Error> input_error;  ///< why the input ended before its end
  double seconds = 0.0;
};

/// Encodes frames as they come and sends them, until there are no more or it is stopped. Frames
/// that cannot be used are reported and left out. An error if the server refuses the publisher for
/// good.
Result<PublishSummary> publish(FrameInput& input, const PublishOptions& options,
                               const PublishListener& listener);

}  // namespace pointreel
