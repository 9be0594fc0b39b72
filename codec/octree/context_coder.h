#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "codec/memory_budget.h"
#include "codec/octree/context_model.h"
#include "codec/octree/range_coder.h"
#include "codec/octree/raster_walk.h"
#include "common/base/byte_io.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"
#include "pointreel/executor.h"
#include "pointreel/octree.h"

/// Codes the masks of a tree level by level with adaptive contexts. The layers of a frame are coded
/// one after another: each continues with the levels, and with the state of the leaves, of the
/// layers before it. FORMAT.md, "Entropy coding context".
///
/// Trust: the decoder takes hostile bytes. The caller bounds the number of masks of a layer by the
/// size of its payload. Memory is bounded by that number, by the caller's number of points, and by
/// the tables: it is at most 150 bytes for each node of the two finest levels above the leaves
/// (three times as much with slabs of one cell each), 8 MiB for each slab, and the leaves of the
/// tables, once more for each slab. Any bytes decode to a tree of these sizes or to an error.
namespace pointreel {

/// The state of the encoder or decoder between levels.
struct ContextState {
  explicit ContextState(std::shared_ptr<const ContextTables> tables);

  /// Moves on from the current level, whose masks are given in Morton order, to the level below.
  void descend(ByteView masks, const Executor& executor);

  /// To be called before coding a level with that many nodes. Large dense levels are very regular,
  /// each in its own way, so there the leaves forget earlier levels sooner.
  void begin_level(int level_class, std::size_t nodes);

  std::shared_ptr<const ContextTables> tables;
  std::vector<Leaf> leaves;
  std::vector<RasterLevel> slabs;  ///< the slabs of the current level; a single one is all of it
  std::vector<std::vector<Leaf>> slab_leaves;
  bool hardware;  ///< whether to gather the bits of a context with the processor's instruction
};

class ContextEncoder {
 public:
  /// Divides large layers into `slabs` slabs, 1 to kMostSlabs.
  explicit ContextEncoder(std::shared_ptr<const ContextTables> tables, int slabs = 1);

  /// Appends the tree's levels from `first_level`, where the last call ended (0 for the first), to
  /// `last_level` - 1. The tree is not empty.
  void encode_layer(const Svo& svo, int first_level, int last_level, Bytes& payload,
                    const Executor& executor = {});

 private:
  void write_slabs(const Svo& svo, int first_level, std::size_t mask_count, Bytes& payload);

  ContextState state_;
  int wanted_slabs_;
};

class ContextDecoder {
 public:
  explicit ContextDecoder(std::shared_ptr<const ContextTables> tables);

  /// Appends the layer's masks to `masks`, level by level in Morton order. Fails if the payload
  /// does not hold exactly `mask_count` masks, or a level has more than `most_nodes` nodes.
  Result<void> decode_layer(ByteView payload, int first_level, int last_level,
                            std::size_t mask_count, std::size_t most_nodes, Bytes& masks,
                            const Executor& executor = {}, MemoryBudget* budget = nullptr);

 private:
  /// Divides the level if this layer says so, and takes the memory for that from the budget, if
  /// there is one. Returns a decoder for the bytes of each slab.
  Result<std::vector<RangeDecoder>> read_slabs(ByteReader& reader, std::size_t mask_count,
                                               MemoryBudget* budget);

  ContextState state_;
  std::size_t nodes_ = 1, children_ = 0;  ///< of the current level
};

}  // namespace pointreel
