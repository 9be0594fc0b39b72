// Opening any bytes as an MCAP recording gives messages or an error, and so does reading each.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "codec/files/mcap.h"
#include "tests/fuzz/target.h"

FUZZ_TARGET(mcap) {
  const auto recording = McapRecording::open(ByteSource(input), {}, 4u << 20);
  if (!recording) {
    require(one_line(recording.error().message));
    return;
  }
  require((*recording)->size() > 0 && (*recording)->size() <= input.size());
  for (std::size_t i = 0; i < (*recording)->size() && i < 16; ++i) {
    const Result<Bytes> message = (*recording)->read(i);
    require(message || one_line(message.error().message));
    require(i == 0 || (*recording)->time_ns(i) >= (*recording)->time_ns(i - 1));
  }
}
