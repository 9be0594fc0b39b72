#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "codec/octree/context_model.h"
#include "codec/octree/range_coder.h"
#include "codec/octree/raster_walk.h"
#include "common/base/byte_io.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"
#include "pointreel/executor.h"
#include "pointreel/octree.h"

/// The masks of a tree, coded level by level with adaptive contexts. Layers follow each other: a
/// later one goes on with the levels, and with what the leaves have learned, of those before it.
/// FORMAT.md, "Entropy coding context".
///
/// Trust: the decoder takes hostile bytes. A layer's number of masks is the caller's, who bounds it
/// by the size of the payload; memory is bounded by it, by the caller's number of points, and by
/// the tables: at most 150 bytes a node of the two finest levels above the leaves (three times that
/// with slabs of one cell each), 8 MiB for each slab, and the leaves of the tables, once more for
/// each slab. Any bytes decode to a tree of those sizes or to an error.
namespace pointreel {

/// What both directions go on with from one level to the next.
struct ContextState {
  explicit ContextState(std::shared_ptr<const ContextTables> tables);

  /// From the level at hand, whose masks are given in Morton order, to that below it.
  void descend(ByteView masks, const Executor& executor);

  /// Before a level of so many nodes. Large dense levels are very regular, each in its own way:
  /// what leaves have learnt before is forgotten sooner there.
  void begin_level(int level_class, std::size_t nodes);

  std::shared_ptr<const ContextTables> tables;
  std::vector<Leaf> leaves;
  std::vector<RasterLevel> slabs;  ///< of the level at hand; one is all of it
  std::vector<std::vector<Leaf>> slab_leaves;
  bool hardware;  ///< whether the processor's own instruction gathers the bits of a context
};

class ContextEncoder {
 public:
  /// Parts large layers into `slabs`, 1 to kMostSlabs.
  explicit ContextEncoder(std::shared_ptr<const ContextTables> tables, int slabs = 1);

  /// Appends to `payload` the tree's levels `first_level` (where the last call ended, 0 at first)
  /// to `last_level` - 1. The tree is not empty.
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

  /// Appends the layer's masks, level by level in Morton order, to `masks`. Refuses a payload that
  /// does not hold `mask_count` masks, and a level with more than `most_nodes` nodes.
  Result<void> decode_layer(ByteView payload, int first_level, int last_level,
                            std::size_t mask_count, std::size_t most_nodes, Bytes& masks,
                            const Executor& executor = {});

 private:
  /// Parts the level if this layer begins with that; a decoder for each slab's bytes.
  Result<std::vector<RangeDecoder>> read_slabs(ByteReader& reader, std::size_t mask_count);

  ContextState state_;
  std::size_t nodes_ = 1, children_ = 0;  ///< of the level at hand
};

}  // namespace pointreel
