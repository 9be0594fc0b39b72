// Reading any bytes as PCD gives a cloud or an error, and no more points than bytes could stand
// for.
#include "tests/fuzz/read_points.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const pointreel::ByteView bytes(data, size);
  if (read_points(bytes, pointreel::CloudFormat::pcd) > 100 * size) std::abort();
  return 0;
}
