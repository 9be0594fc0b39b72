#include "tests/forge.h"

#include <xxhash.h>

#include "pointreel/chunks.h"

namespace pointreel {
namespace {

constexpr std::size_t kChecksum = sizeof(std::uint64_t);

std::uint64_t checksum(ByteView header, ByteView payload) {
  return XXH3_64bits_withSeed(payload.data(), payload.size(),
                              XXH3_64bits(header.data(), header.size()));
}

}  // namespace

void mend_frame_header(Bytes& geometry) {
  if (geometry.size() < kFrameHeaderSize) return;
  const std::size_t end = kFrameHeaderSize - kChecksum;
  put_at(geometry, end, checksum(ByteView(geometry).first(end), {}));
}

void mend_chunk(Bytes& part, std::size_t begin) {
  if (part.size() < begin + kChunkHeaderSize) return;
  const std::size_t header = kChunkHeaderSize - kChecksum;
  const ByteView chunk = ByteView(part).subspan(begin);
  put_at(part, begin + header, checksum(chunk.first(header), chunk.subspan(kChunkHeaderSize)));
}

void mend(EncodedFrame& frame) {
  for (std::size_t layer = 0; layer < frame.layers.size(); ++layer) {
    for (const ChunkKind kind : {ChunkKind::geometry, ChunkKind::colors, ChunkKind::normals}) {
      mend_chunk(chunk_of(frame.layers[layer], kind), chunk_begin(layer, kind));
    }
  }
  if (!frame.layers.empty()) mend_frame_header(frame.layers.front().geometry);
}

std::size_t chunk_begin(std::size_t layer, ChunkKind kind) {
  return layer == 0 && kind == ChunkKind::geometry ? kFrameHeaderSize : 0;
}

}  // namespace pointreel
