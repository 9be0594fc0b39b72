// Reading any bytes as glTF gives a cloud or an error, within the limits, and so does looking for
// buffers in other files, of which there are none.
#include "codec/formats/gltf_buffers.h"
#include "tests/fuzz/read_points.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const pointreel::ByteView bytes(data, size);
  if (read_points(bytes, pointreel::CloudFormat::gltf) > (1u << 20)) std::abort();
  if (pointreel::embed_gltf_buffers(bytes, "/nonexistent", 1u << 20).value_or(std::nullopt))
    std::abort();
  return 0;
}
