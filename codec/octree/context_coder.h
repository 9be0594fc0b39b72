#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "codec/octree/context_model.h"
#include "codec/octree/memory_budget.h"
#include "codec/octree/slice_level.h"
#include "codec/octree/symbol_coder.h"
#include "common/base/byte_io.h"
#include "pointreel/bytes.h"
#include "pointreel/error.h"
#include "pointreel/executor.h"
#include "pointreel/octree.h"

/// Codes the masks of a tree level by level with adaptive alphabets. The layers of a frame are
/// coded one after another: each continues with the levels, and with the state of the alphabets, of
/// the layers before it. FORMAT.md, "Entropy coding context".
///
/// Large frames are divided into slabs along z that are coded in parallel, each with alphabets of
/// its own. The nodes of a level are known before any of its masks, so a slab sees the nodes of the
/// slabs next to it, but not their masks.
///
/// Trust: the decoder takes hostile bytes. The caller bounds the number of masks of a layer by the
/// size of its payload. Memory is bounded by that number, by the caller's number of points, and by
/// the tables: it is at most 170 bytes for each node of the two finest levels above the leaves, 8
/// MiB for each slab, and the alphabets of the tables, once more for each slab. Any bytes decode to
/// a tree of these sizes or to an error.
namespace pointreel {

inline constexpr int kMostSlabs = 16;
/// The layer in which slabs begin must have this many masks for each of them. This bounds the
/// memory that a few bytes can make a reader allocate.
inline constexpr std::size_t kLeastMasksOfSlab = 4096;

/// The default number of slabs of a frame with that many leaves. It is 1 below 2^20 leaves, where a
/// frame takes a few hundredths of a second and coding several frames in parallel uses all cores;
/// from there on, it is one for each 2^19 leaves.
int default_slabs(std::size_t leaves);

/// The state of the encoder or decoder between levels.
struct ContextState {
  explicit ContextState(std::shared_ptr<const ContextTables> tables);

  /// Moves on from the current level, whose masks are known, to the level below. `masks`: the same
  /// masks in Morton order.
  void descend(ByteView masks);

  /// Divides this and all later levels. `begins`: the z at which all slabs but the first begin.
  void divide(std::vector<std::uint32_t> begins);

  std::size_t slabs() const { return alphabets.size(); }
  /// The slices of a slab: [first_slice(slab), first_slice(slab + 1)).
  std::size_t first_slice(std::size_t slab) const;

  std::shared_ptr<const ContextTables> tables;
  SliceLevel level;
  std::vector<std::uint32_t> slab_begins;          ///< in nodes of the current level
  std::vector<std::vector<Alphabet16>> alphabets;  ///< of each slab
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
  Result<std::vector<SymbolDecoder>> read_slabs(ByteReader& reader, std::size_t mask_count,
                                                MemoryBudget* budget);

  ContextState state_;
  std::size_t nodes_ = 1, children_ = 0;  ///< of the current level
};

}  // namespace pointreel
