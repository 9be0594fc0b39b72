#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "codec/octree/context_coder.h"
#include "codec/octree/frame_header.h"
#include "codec/octree/memory_budget.h"
#include "pointreel/bytes.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/octree.h"

/// The geometry chunks of a frame's layers, base first, in all entropy codings. FORMAT.md, "Layers"
/// and "Entropy coding context".
///
/// Trust: the decoder takes hostile bytes. The memory that it allocates is bounded by the sizes of
/// the payloads (max_raw_size) and by the number of points in the header.
namespace pointreel {

class GeometryEncoder {
 public:
  /// `tables`: as in OctreeOptions. `slabs`: at least 1.
  static Result<GeometryEncoder> create(Entropy entropy,
                                        const std::shared_ptr<const ContextTables>& tables,
                                        int slabs);

  /// Appends the chunk of the levels from `first_level` to header.last_level - 1.
  void encode_layer(const Svo& svo, int first_level, ChunkHeader header, FrameTag tag,
                    const Executor& executor, Bytes& out);

 private:
  std::optional<ContextEncoder> context_;  ///< only for Entropy::context
  Bytes tables_name_;                      ///< names the tables at the start of the first payload
};

class GeometryDecoder {
 public:
  /// `points`: the number of leaves of the whole frame. `tables`: as in DecodeLimits.
  explicit GeometryDecoder(std::uint32_t points, const ContextTables* tables)
      : points_(points), level_nodes_(points > 0), given_tables_(tables) {}

  /// Appends the masks of a layer, level by level in Morton order.
  Result<void> decode_layer(const ParsedChunk& chunk, int first_level, const Executor& executor,
                            MemoryBudget& budget, Bytes& masks);

  /// The number of nodes at the level where the last decoded layer ends.
  std::uint64_t level_nodes() const { return level_nodes_; }

 private:
  Result<void> decode_context(const ParsedChunk& chunk, int first_level, const Executor& executor,
                              MemoryBudget& budget, Bytes& masks);
  /// Finds the tables that the first layer's payload names, and removes the name from its front.
  Result<std::shared_ptr<const ContextTables>> take_tables(ByteView& payload) const;
  Result<void> count_nodes(ByteView masks, int levels);

  std::uint32_t points_;
  std::uint64_t level_nodes_;
  const ContextTables* given_tables_;
  std::optional<ContextDecoder> context_;  ///< only if the first layer uses Entropy::context
};

}  // namespace pointreel
