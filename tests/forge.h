#pragma once

#include <cstddef>
#include <cstring>

#include "codec/octree/frame_header.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"

/// Makes frames that no encoder writes: after bytes of a good frame were changed, these functions
/// correct all checksums, so that tests get past them.
namespace pointreel {

/// Recomputes the checksum at the end of the frame header that `geometry` begins with, if it is
/// long enough to have one.
void mend_frame_header(Bytes& geometry);

/// The same for the chunk that begins at offset `begin`.
void mend_chunk(Bytes& part, std::size_t begin);

/// Recomputes all checksums of a frame.
void mend(EncodedFrame& frame);

/// The offset at which a chunk begins: in the first layer's geometry, after the frame header.
std::size_t chunk_begin(std::size_t layer, ChunkKind kind);

/// Overwrites little-endian bytes at an offset.
template <class T>
void put_at(Bytes& bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof(T));
}

}  // namespace pointreel
