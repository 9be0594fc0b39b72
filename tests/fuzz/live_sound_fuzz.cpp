// Sound of live streams, from a hostile publisher through the viewer's decoder.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "client/sound/live_track.h"
#include "codec/live/live_sound.h"
#include "common/base/byte_io.h"
#include "tests/fuzz/target.h"

/// The input is messages, each behind its size in two bytes. Whatever is accepted is written again
/// as it was, and what is heard of it is finite. The header's checksum is made right, or the fuzzer
/// would not get past it.
FUZZ_TARGET(live_sound, .longest = 1 << 13) {
  (void)parse_live_sound_file(input);
  LiveTrack track;
  ByteView rest = input;
  while (rest.size() > 2) {
    const std::size_t length = std::min<std::size_t>(rest[0] + 256u * rest[1], rest.size() - 2);
    Bytes message(rest.begin() + 2, rest.begin() + 2 + static_cast<std::ptrdiff_t>(length));
    rest = rest.subspan(2 + length);
    (void)parse_live_sound(message);
    if (message.size() > kSoundHeaderSize) {
      ByteReader in(message);
      LiveSound said;
      in.get<std::uint32_t>();
      said.number = in.get<std::uint32_t>();
      said.capture_us = in.get<std::uint64_t>();
      said.samples = in.get<std::uint16_t>();
      said.packet = ByteView(message).subspan(kSoundHeaderSize);
      message = write_live_sound(said);
    }
    const auto sound = parse_live_sound(message);
    if (!sound) {
      if (sound.error().message.empty()) std::abort();
      continue;
    }
    if (write_live_sound(*sound) != message) std::abort();
    track.add(*sound, sound->capture_us + 1000);
    const Clock::TimePoint now{std::chrono::hours(1)};
    const auto clock = track.clock(now, sound->capture_us + 50'000, std::nullopt);
    if (!clock) continue;
    std::vector<StereoSample> heard(960);
    track.copy(static_cast<std::int64_t>(clock->read(now).position_us) * 48 / 1000, heard);
    for (const StereoSample& sample : heard)
      if (!std::isfinite(sample.left) || !std::isfinite(sample.right)) std::abort();
  }
}
