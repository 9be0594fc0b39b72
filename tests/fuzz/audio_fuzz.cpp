#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "codec/audio/opus_reader.h"
#include "tests/fuzz/ogg_checksums.h"
#include "tests/fuzz/target.h"

namespace pointreel::fuzz::audio {

/// Reads on, for a second of sound at most.
void read(OpusReader& reader) {
  std::vector<StereoSample> buffer(kAudioRate / 10);
  for (int i = 0; i < 10; ++i) {
    const auto got = reader.read(buffer);
    if (!got) return require(one_line(got.error().message));
    if (got->samples > buffer.size()) std::abort();
    if (got->samples == 0) return;
    for (std::size_t n = 0; n < got->samples; ++n)
      if (!(std::abs(buffer[n].left) <= 1.0f && std::abs(buffer[n].right) <= 1.0f)) std::abort();
  }
}

/// Packets follow each other, and have the lengths that packets may have.
void read_packets(const std::vector<std::uint8_t>& bytes) {
  auto reader = OpusReader::open(bytes);
  if (!reader) return;
  const OpusReader::Head head = reader->head();
  if (head.channels < 1 || head.skip > 65'535) std::abort();
  std::int64_t end = -static_cast<std::int64_t>(head.skip);
  for (;;) {
    const auto got = reader->packets();
    if (!got) return require(one_line(got.error().message));
    if (got->packets.empty()) return;
    for (const OpusReader::Packet& packet : got->packets) {
      if (packet.first < end || packet.end < packet.first) std::abort();
      if (packet.samples < 120 || packet.samples > 5'760) std::abort();
      if (packet.bytes.size() > bytes.size()) std::abort();
      end = packet.end;
    }
  }
}

}  // namespace pointreel::fuzz::audio

/// Any bytes give packets, and samples from -1 to 1, from any place on, or an error of one line.
FUZZ_TARGET(audio, .longest = 1 << 16) {
  std::vector<std::uint8_t> bytes(input.begin(), input.end());
  set_checksums(bytes);
  auto reader = OpusReader::open(bytes);
  if (!reader) {
    require(one_line(reader.error().message));
    return;
  }
  read(*reader);
  read_packets(bytes);
  for (const std::uint64_t sample : {reader->samples() / 2, std::uint64_t{0}, reader->samples()}) {
    if (const auto sought = reader->seek(sample); !sought) {
      require(one_line(sought.error().message));
    } else {
      read(*reader);
    }
  }
}
