// Reading any bytes as OBJ gives a cloud or an error, and no more points than bytes.
#include "tests/fuzz/read_points.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const pointreel::ByteView bytes(data, size);
  if (read_points(bytes, pointreel::CloudFormat::obj) > size) std::abort();
  return 0;
}
