#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "codec/octree/context_model.h"
#include "codec/octree/raster_walk.h"
#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/octree/svo.h"

/// The masks of a tree, coded level by level with adaptive contexts. Layers follow each other: a
/// later one goes on with the levels, and with what the leaves have learned, of those before it.
/// FORMAT.md, "Entropy coding context".
///
/// Trust: the decoder takes hostile bytes. A layer's number of masks is the caller's, who bounds it
/// by the size of the payload; memory is bounded by it, by the caller's number of points, and by
/// the tables. Any bytes decode to a tree of those sizes or to an error.
namespace pointreel {

/// How the bits of a context are gathered; the result is the same.
enum class ExtractPath { fastest, portable };

class ContextEncoder {
 public:
  explicit ContextEncoder(std::shared_ptr<const ContextTables> tables,
                          ExtractPath path = ExtractPath::fastest);

  /// Appends to `payload` the tree's levels `first_level` (where the last call ended, 0 at first)
  /// to `last_level` - 1. The tree is not empty.
  void encode_layer(const Svo& svo, int first_level, int last_level, Bytes& payload);

 private:
  std::shared_ptr<const ContextTables> tables_;
  std::vector<Leaf> leaves_;
  RasterLevel level_;
  bool hardware_;
};

class ContextDecoder {
 public:
  explicit ContextDecoder(std::shared_ptr<const ContextTables> tables,
                          ExtractPath path = ExtractPath::fastest);

  /// Appends the layer's masks, level by level in Morton order, to `masks`. Refuses a payload that
  /// does not hold `mask_count` masks, and a level with more than `most_nodes` nodes.
  Result<void> decode_layer(ByteView payload, int first_level, int last_level,
                            std::size_t mask_count, std::size_t most_nodes, Bytes& masks);

 private:
  std::shared_ptr<const ContextTables> tables_;
  std::vector<Leaf> leaves_;
  RasterLevel level_;
  bool hardware_;
};

}  // namespace pointreel
