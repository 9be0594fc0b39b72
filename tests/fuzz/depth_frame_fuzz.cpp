// Reading any bytes as intrinsics with pictures of depth and colours gives a cloud within the
// limits, or an error.
#include "tests/fuzz/read_points.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const pointreel::ByteView bytes(data, size);
  if (read_points(bytes, pointreel::CloudFormat::depth_frame) > (1u << 20)) std::abort();
  return 0;
}
