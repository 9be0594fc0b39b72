#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "codec/frame_header.h"
#include "codec/octree/context_coder.h"
#include "pointreel/bytes.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/octree.h"

/// Geometry chunks of a frame's layers, base first, in any entropy coding. FORMAT.md, "Octree
/// frames" and "Entropy coding context".
///
/// Trust: the decoder takes hostile bytes. What it allocates is bounded by the payloads
/// (max_raw_size) and by the header's number of points.
namespace pointreel {

class GeometryEncoder {
 public:
  /// `tables` as in OctreeOptions; `slabs` at least 1.
  static Result<GeometryEncoder> create(Entropy entropy,
                                        const std::shared_ptr<const ContextTables>& tables,
                                        int slabs);

  /// Appends the chunk of the levels from `first_level` to before header.last_level.
  void encode_layer(const Svo& svo, int first_level, ChunkHeader header, FrameTag tag,
                    const Executor& executor, Bytes& out);

 private:
  std::optional<ContextEncoder> context_;  ///< with entropy context
  Bytes tables_name_;                      ///< what a frame of entropy context begins with
};

class GeometryDecoder {
 public:
  /// `points`: number of leaves of the whole frame. `tables`: as in DecodeLimits.
  explicit GeometryDecoder(std::uint32_t points, const ContextTables* tables)
      : points_(points), level_nodes_(points > 0), given_tables_(tables) {}

  /// Appends one layer's masks, level by level in Morton order.
  Result<void> decode_layer(const ParsedChunk& chunk, int first_level, const Executor& executor,
                            Bytes& masks);

  /// Nodes at the level where the last layer ends.
  std::uint64_t level_nodes() const { return level_nodes_; }

 private:
  Result<void> decode_context(const ParsedChunk& chunk, int first_level, const Executor& executor,
                              Bytes& masks);
  /// The tables that the first layer's payload names; takes the name off its front.
  Result<std::shared_ptr<const ContextTables>> take_tables(ByteView& payload) const;
  Result<void> count_nodes(ByteView masks, int levels);

  std::uint32_t points_;
  std::uint64_t level_nodes_;
  const ContextTables* given_tables_;
  std::optional<ContextDecoder> context_;  ///< if the first layer's entropy coding is context
};

}  // namespace pointreel
