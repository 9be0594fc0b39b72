// Reading any bytes as glTF gives a cloud or an error, within the limits.
#include "tests/fuzz/read_points.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const pointreel::ByteView bytes(data, size);
  if (read_points(bytes, pointreel::CloudFormat::gltf) > (1u << 20)) std::abort();
  return 0;
}
