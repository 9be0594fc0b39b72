#pragma once

#include <cstdint>

#include "codec/octree/frame_header.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"

/// The payload of a chunk whose entropy coding is none or zstd.
namespace pointreel {

/// The largest raw size that a payload of `stored` bytes may have. It bounds the memory that a few
/// hostile bytes can make a reader allocate. It may exceed the memory of a machine of 32 bits.
constexpr std::uint64_t max_raw_size(std::uint64_t stored) { return 64 * 1024 + 1024 * stored; }

/// Appends a chunk that holds `raw`, coded as header.entropy says, which is none or zstd. Uses none
/// where zstd would gain nothing or would exceed max_raw_size.
void pack_chunk(ChunkHeader header, FrameTag tag, ByteView raw, Bytes& out);

/// Undoes the entropy coding of a chunk whose raw size must be `expected_size`.
///
/// Trust: the payload may be hostile. The size is compared with the header and with max_raw_size
/// before memory is taken for it.
Result<Bytes> unpack_chunk(const ParsedChunk& chunk, std::size_t expected_size);

}  // namespace pointreel
