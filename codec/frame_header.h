#pragma once

#include <cstdint>

#include "pointreel/bytes.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"

/// The headers that every codec's frames share; FORMAT.md, "Frame" and "Chunk".
///
/// Trust: these parse hostile bytes. Every field is checked against its range, every size against
/// the bytes that are there, and both headers and payloads against their checksums; nothing is
/// allocated. A checksum keeps out damage, not a forger: what passes is still bounded by its
/// decoder.
namespace pointreel {

inline constexpr std::uint8_t kFrameVersion = 1;
inline constexpr std::size_t kFrameHeaderSize = 64;
inline constexpr std::size_t kChunkHeaderSize = 24;

/// What the whole frame is. Stands at the start of the first layer's geometry.
struct FrameHeader {
  Codec codec = Codec::octree;
  std::uint8_t depth = 0;  ///< octree: level of the leaves; Draco: position bits
  bool has_colors = false;
  bool has_normals = false;
  bool colors_16_bit = false;
  bool colors_transformed = false;   ///< octree: lossy colours, attribute_coder.h
  bool normals_transformed = false;  ///< octree: normals likewise
  std::uint8_t layers = 1;           ///< that the whole frame has
  std::uint32_t source_points = 0;
  std::uint32_t coded_points = 0;
  Cube cube;
};

enum class ChunkKind : std::uint8_t { geometry = 0, colors = 1, normals = 2 };

/// What one chunk holds.
struct ChunkHeader {
  ChunkKind kind = ChunkKind::geometry;
  Entropy entropy = Entropy::none;
  std::uint8_t layer = 0;
  std::uint8_t last_level = 0;  ///< octree: level whose nodes the layer ends at
  std::uint32_t raw_size = 0;   ///< bytes of the payload once its entropy coding is undone
};

/// Identifies a frame's content, so that a chunk of another frame is not taken for this one's.
using FrameTag = std::uint32_t;

/// Whether positions relative to the cube are finite floats that tell its cells apart: its edge is
/// between 1e-30 and 1e30.
bool is_codable(const Cube& cube);

void write_frame_header(const FrameHeader& header, FrameTag tag, Bytes& out);

struct ParsedFrameHeader {
  FrameHeader header;
  FrameTag tag = 0;
  ByteView rest;  ///< what follows the header
};
Result<ParsedFrameHeader> read_frame_header(ByteView bytes);

/// Appends a chunk: header, checksum, payload.
void write_chunk(const ChunkHeader& header, FrameTag tag, ByteView payload, Bytes& out);

struct ParsedChunk {
  ChunkHeader header;
  ByteView payload;
};
/// `bytes` is exactly one chunk, of this kind and layer of the frame that the tag identifies.
Result<ParsedChunk> read_chunk(ByteView bytes, ChunkKind kind, std::uint8_t layer, FrameTag tag);

}  // namespace pointreel
