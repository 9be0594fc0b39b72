// Reading any bytes as a message of ROS 2 gives a cloud or an error, and no more points than bytes.
#include "tests/fuzz/read_points.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const pointreel::ByteView bytes(data, size);
  if (read_points(bytes, pointreel::CloudFormat::point_cloud2) > size) std::abort();
  return 0;
}
