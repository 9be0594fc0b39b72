#pragma once

#include <cstdint>

#include "pointreel/bytes.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"

/// The headers that the frames of all codecs share: FORMAT.md, "Frame header" and "Chunk".
///
/// Trust: the parsers take hostile bytes. They check the range of every field, every size against
/// the bytes that are there, and the checksums of headers and payloads, and allocate nothing. A
/// checksum reveals damage but does not stop a forger, so decoders must still distrust the payload.
namespace pointreel {

inline constexpr std::uint8_t kFrameVersion = 2;
inline constexpr std::size_t kFrameHeaderSize = 64;
inline constexpr std::size_t kChunkHeaderSize = 24;

/// Describes the whole frame. It comes first in the geometry of the first layer.
struct FrameHeader {
  Codec codec = Codec::octree;
  std::uint8_t depth = 0;  ///< octree: level of the leaves; Draco: position bits
  bool has_colors = false;
  bool has_normals = false;
  bool colors_16_bit = false;
  bool colors_transformed = false;   ///< octree: lossy colours (attribute_coder.h)
  bool normals_transformed = false;  ///< octree: lossy normals
  std::uint8_t layers = 1;           ///< the number of layers of the whole frame
  std::uint32_t source_points = 0;
  std::uint32_t coded_points = 0;
  Cube cube;
};

/// `scalars` stands alone, in the layer after those of the geometry.
enum class ChunkKind : std::uint8_t { geometry = 0, colors = 1, normals = 2, scalars = 3 };

/// The chunk of that kind, which is not `scalars`, or what stands for it.
template <class AnyChunks>
auto& chunk_of(AnyChunks& chunks, ChunkKind kind) {
  return kind == ChunkKind::geometry ? chunks.geometry
         : kind == ChunkKind::colors ? chunks.colors
                                     : chunks.normals;
}

/// Describes the content of a chunk.
struct ChunkHeader {
  ChunkKind kind = ChunkKind::geometry;
  Entropy entropy = Entropy::none;
  std::uint8_t layer = 0;
  std::uint8_t last_level = 0;  ///< octree: the level at which the layer ends
  std::uint32_t raw_size = 0;   ///< the payload's size once its entropy coding is undone
};

/// Identifies a frame, so that chunks of different frames are not mixed.
using FrameTag = std::uint32_t;

/// True if the cube's corner is finite and its edge is between 1e-30 and 1e30, so that positions
/// relative to it are finite floats that can tell its cells apart.
bool is_codable(const Cube& cube);
/// The same for points that are to be encoded, as an error (`argument`).
Result<void> check_codable(const Cube& cube);

void write_frame_header(const FrameHeader& header, FrameTag tag, Bytes& out);

struct ParsedFrameHeader {
  FrameHeader header;
  FrameTag tag = 0;
  ByteView rest;  ///< the bytes after the header
};
/// Errors: `unsupported` for another version or an unknown codec, otherwise `invalid`.
Result<ParsedFrameHeader> read_frame_header(ByteView bytes);

/// Appends a chunk: header, checksum, payload.
void write_chunk(const ChunkHeader& header, FrameTag tag, ByteView payload, Bytes& out);

struct ParsedChunk {
  ChunkHeader header;
  ByteView payload;
};
/// `bytes` must be exactly one chunk, of this kind and layer, of the frame that the tag identifies.
/// Errors: `unsupported` for an unknown entropy coding, otherwise `invalid`.
Result<ParsedChunk> read_chunk(ByteView bytes, ChunkKind kind, std::uint8_t layer, FrameTag tag);

}  // namespace pointreel
