#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "client/bindings/frames/encoded_bytes.h"
#include "codec/live/live.h"
#include "tests/fuzz/target.h"

namespace pointreel::fuzz::encoded_bytes {

/// Removes `size` bytes, or all that are left, from the front.
ByteView take(ByteView& bytes, std::size_t size) {
  const ByteView taken = bytes.first(std::min(size, bytes.size()));
  bytes = bytes.subspan(taken.size());
  return taken;
}

/// Takes the fields of headers from the input, and adds the checksums without which nothing behind
/// them would be looked at.
Bytes with_headers(ByteView input) {
  Bytes bytes;
  while (input.size() > 8) {
    const ByteView fields = take(input, 8);
    LiveLayer layer;
    layer.layer = fields[0] & 15;
    layer.layers = fields[0] >> 4;
    layer.points = fields[1];
    layer.sizes = {static_cast<std::uint32_t>(fields[2] | fields[3] << 8), fields[4] * 4u,
                   fields[5] * 4u};
    const Bytes header = write_live_header(layer);
    bytes.insert(bytes.end(), header.begin(), header.end());
    const ByteView content = take(input, total(layer.sizes));
    bytes.insert(bytes.end(), content.begin(), content.end());
  }
  return bytes;
}

}  // namespace pointreel::fuzz::encoded_bytes

/// Decodes a single frame from bytes. What is accepted has arrays that go together; what is not has
/// a message, and no memory beyond the limit is taken.
FUZZ_TARGET(encoded_bytes, .longest = 1 << 14) {
  if (input.empty()) return;
  const ByteView rest = input.subspan(1);
  const Bytes bytes = input[0] % 2 == 0 ? Bytes(rest.begin(), rest.end()) : with_headers(rest);
  ReadLimits limits;
  limits.max_memory = std::uint64_t{64} << 20;
  limits.layers = input[0] / 2 % 4 == 0 ? kAllLayers : input[0] / 2 % 4;
  const auto frame = decode_bytes(bytes, limits);
  if (!frame) {
    if (frame.error().message.empty()) std::abort();
    return;
  }
  const PointCloud& cloud = (*frame)->cloud;
  if ((cloud.has_colors() && cloud.colors.size() != cloud.size()) ||
      (cloud.has_normals() && cloud.normals.size() != cloud.size()) ||
      (*frame)->layers > limits.layers) {
    std::abort();
  }
}
