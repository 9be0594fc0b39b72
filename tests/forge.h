#pragma once

#include <cstddef>
#include <cstring>

#include "codec/frame_header.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"

/// Frames that no encoder writes: bytes of good ones are changed, and then all checksums made right
/// again, so that what comes behind them is tested and not only they.
namespace pointreel {

/// Recomputes the checksum at the end of the frame header that `geometry` begins with, if it is
/// long enough to have one.
void mend_frame_header(Bytes& geometry);

/// The same of the chunk that begins at `begin`.
void mend_chunk(Bytes& part, std::size_t begin);

/// All checksums of a frame.
void mend(EncodedFrame& frame);

Bytes& part_of(Chunks<Bytes>& layer, ChunkKind kind);

/// Where the chunk of this part begins: behind the frame header in the first layer's geometry.
std::size_t chunk_begin(std::size_t layer, ChunkKind kind);

/// Overwrites little-endian bytes at an offset.
template <class T>
void put_at(Bytes& bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof(T));
}

}  // namespace pointreel
