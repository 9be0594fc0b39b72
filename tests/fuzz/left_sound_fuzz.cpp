// What a killed program left of the sound of a recording.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "codec/audio/opus_reader.h"
#include "server/relay/left_sound.h"
#include "tests/fuzz/ogg_checksums.h"
#include "tests/fuzz/target.h"

/// What is found lies in the file, and is found again in what was found. A reader opens it or says
/// in one line why not.
FUZZ_TARGET(left_sound, .longest = 1 << 16) {
  std::vector<std::uint8_t> bytes(input.begin(), input.end());
  set_checksums(bytes);
  const LeftSound left = find_left_sound(bytes);
  if (left.bytes > input.size() || (left.bytes == 0 && left.samples != 0)) std::abort();
  const ByteView front = ByteView(bytes).first(left.bytes);
  const LeftSound again = find_left_sound(front);
  if (again.bytes != left.bytes || again.samples != left.samples) std::abort();
  const auto reader = OpusReader::open(front);
  if (!reader && reader.error().message.empty()) std::abort();
}
