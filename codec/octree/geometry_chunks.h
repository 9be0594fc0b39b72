#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "codec/codec.h"
#include "codec/frame_header.h"
#include "codec/octree/context_coder.h"
#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/octree/svo.h"

/// Geometry chunks of a frame's layers, base first, in any entropy coding. FORMAT.md, "Octree
/// frames" and "Entropy coding context".
///
/// Trust: the decoder takes hostile bytes. What it allocates is bounded by the payloads
/// (max_raw_size) and by the header's number of points.
namespace pointreel {

class GeometryEncoder {
 public:
  static Result<GeometryEncoder> create(Entropy entropy);

  /// Appends the chunk of the levels from `first_level` to before header.last_level.
  void encode_layer(const Svo& svo, int first_level, ChunkHeader header, FrameTag tag, Bytes& out);

 private:
  std::optional<ContextEncoder> context_;  ///< with entropy context
};

class GeometryDecoder {
 public:
  /// `points`: number of leaves of the whole frame.
  explicit GeometryDecoder(std::uint32_t points) : points_(points), level_nodes_(points > 0) {}

  /// Appends one layer's masks, level by level in Morton order.
  Result<void> decode_layer(const ParsedChunk& chunk, int first_level, Bytes& masks);

  /// Nodes at the level where the last layer ends.
  std::uint64_t level_nodes() const { return level_nodes_; }

 private:
  Result<void> decode_context(const ParsedChunk& chunk, int first_level, Bytes& masks);
  Result<void> count_nodes(ByteView masks, int levels);

  std::uint32_t points_;
  std::uint64_t level_nodes_;
  std::optional<ContextDecoder> context_;  ///< if the first layer's entropy coding is context
};

}  // namespace pointreel
