#include "codec/octree/chunk_payload.h"

#include <zstd.h>

#include "common/base/concat.h"

namespace pointreel {
namespace {

constexpr int kZstdLevel = 3;

}  // namespace

void pack_chunk(ChunkHeader header, FrameTag tag, ByteView raw, Bytes& out) {
  header.raw_size = static_cast<std::uint32_t>(raw.size());
  if (header.entropy == Entropy::zstd) {
    Bytes packed(ZSTD_compressBound(raw.size()));
    const std::size_t size =
        ZSTD_compress(packed.data(), packed.size(), raw.data(), raw.size(), kZstdLevel);
    if (!ZSTD_isError(size) && size < raw.size() && raw.size() <= max_raw_size(size)) {
      write_chunk(header, tag, ByteView(packed).first(size), out);
      return;
    }
    header.entropy = Entropy::none;
  }
  write_chunk(header, tag, raw, out);
}

Result<Bytes> unpack_chunk(const ParsedChunk& chunk, std::size_t expected_size) {
  if (chunk.header.entropy == Entropy::context) {
    return fail("chunk has entropy coding context, but only none and zstd are allowed here");
  }
  const bool stored = chunk.header.entropy == Entropy::none;
  const std::uint64_t most = stored ? chunk.payload.size() : max_raw_size(chunk.payload.size());
  if (chunk.header.raw_size != expected_size || expected_size > most ||
      (stored && expected_size != chunk.payload.size())) {
    return fail(concat("chunk holds ", chunk.header.raw_size, " bytes in ", chunk.payload.size(),
                       ", but ", expected_size, " are needed"));
  }
  if (stored) return Bytes(chunk.payload.begin(), chunk.payload.end());
  Bytes raw(expected_size);
  const std::size_t size =
      ZSTD_decompress(raw.data(), raw.size(), chunk.payload.data(), chunk.payload.size());
  if (ZSTD_isError(size) || size != expected_size) return fail("chunk's zstd data is damaged");
  return raw;
}

}  // namespace pointreel
