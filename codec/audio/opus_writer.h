#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>

#include "codec/audio/opus_reader.h"
#include "common/base/running_checksum.h"
#include "pointreel/bytes.h"

namespace pointreel {

/// 20 ms of silence in both channels, as the format has it for lost packets.
inline constexpr std::array<std::uint8_t, 3> kOpusSilence{0xfc, 0xff, 0xfe};
inline constexpr std::uint32_t kOpusSilenceSamples = 960;

/// Writes packets of Opus into a file, in Ogg (RFC 7845).
class OpusWriter {
 public:
  /// Replaces a file that is there. `head.plain` must be set.
  OpusWriter(const std::filesystem::path& file, const OpusReader::Head& head);
  ~OpusWriter();
  OpusWriter(const OpusWriter&) = delete;
  OpusWriter& operator=(const OpusWriter&) = delete;

  /// `end`: samples from the beginning of the file to the end of this packet, with those that are
  /// not heard. That of the last packet may be lower, and what lies beyond it is not heard.
  void put(ByteView packet, std::uint64_t end, bool last = false);
  /// Writes what waits for a page to be full.
  void flush();

  /// Of the file so far, without what waits.
  std::uint64_t bytes() const { return bytes_; }
  std::uint64_t checksum() const { return checksum_.value(); }
  /// False if something could not be written.
  bool good() const { return out_.good(); }

 private:
  class Stream;

  void write_pages(bool all);

  std::ofstream out_;
  std::unique_ptr<Stream> stream_;
  std::int64_t number_ = 0;
  std::uint64_t bytes_ = 0;
  RunningChecksum checksum_;
};

}  // namespace pointreel
