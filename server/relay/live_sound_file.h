#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "codec/audio/opus_writer.h"
#include "codec/live/live_sound.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel {

/// The sound of a recording: packets of Opus in Ogg (RFC 7845), in a file that grows beside the
/// package until it is needed as a whole. Where packets are missing, there is silence.
///
/// Trust: packets may be hostile. Those whose length is not as stated are left out; others are not
/// decoded. No more than kMostBytes are kept; what comes later is silence.
class LiveSoundFile {
 public:
  static constexpr std::uint64_t kMostBytes = 256u << 20;

  /// `start_us`: the time of capture of the first sample.
  LiveSoundFile(std::filesystem::path file, std::uint64_t start_us);
  /// Removes the file.
  ~LiveSoundFile();
  LiveSoundFile(const LiveSoundFile&) = delete;
  LiveSoundFile& operator=(const LiveSoundFile&) = delete;

  /// Packets in the order of their times. What cannot be written is lost.
  void add(const LiveSound& sound);
  std::uint64_t samples() const { return samples_; }
  /// The whole file so far. Errors: `io`.
  Result<Bytes> bytes();

 private:
  void put(ByteView packet, std::uint64_t samples);

  const std::filesystem::path file_;
  const std::uint64_t start_us_;
  std::uint64_t samples_ = 0;
  std::optional<OpusWriter> writer_;
};

}  // namespace pointreel
