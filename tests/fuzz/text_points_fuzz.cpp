// Reading any bytes as lines of numbers gives a cloud or an error, and no more points than bytes.
#include "tests/fuzz/read_points.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const pointreel::ByteView bytes(data, size);
  if (read_points(bytes, pointreel::CloudFormat::text) > size) std::abort();
  return 0;
}
