// Reading any bytes as glTF gives a cloud or an error, within the limits, and so does looking for
// buffers in other files, of which there are none.
#include "codec/files/gltf_buffers.h"
#include "tests/fuzz/read_points.h"

FUZZ_TARGET(gltf) {
  require(read_points(input, CloudFormat::gltf) <= (1u << 20));
  require(!embed_gltf_buffers(input, "/nonexistent", 1u << 20).value_or(std::nullopt));
}
