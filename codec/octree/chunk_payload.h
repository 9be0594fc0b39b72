#pragma once

#include "codec/frame_header.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

/// The payload of a chunk: raw bytes as they are, or zstd.
namespace pointreel {

/// The most raw bytes that a payload of this size may stand for: what a few hostile bytes can make
/// a reader allocate.
inline std::size_t max_raw_size(std::size_t stored) { return 64 * 1024 + 1024 * stored; }

/// Appends a chunk that holds `raw`. Falls back to Entropy::none where zstd would gain nothing or
/// break max_raw_size. The entropy is one of these two.
void pack_chunk(ChunkHeader header, FrameTag tag, ByteView raw, Bytes& out);

/// Undoes the entropy coding. `expected_size` is what the caller knows the raw bytes must be.
///
/// Trust: the payload may be hostile; the size is compared with the header and with the bound on
/// expansion before memory is taken for it.
Result<Bytes> unpack_chunk(const ParsedChunk& chunk, std::size_t expected_size);

}  // namespace pointreel
