#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "codec/octree/node_planes.h"
#include "codec/octree/orientation.h"
#include "codec/octree/slice_level.h"

/// The words on which the contexts of sparse levels depend. All that they tell is known before any
/// mask of the level, so they are found for a whole slice first. FORMAT.md, "Words of sparse
/// levels".
namespace pointreel {

namespace sparse_word {

/// The bits of a word in use, and those that hold the lower half of the mask where it is known.
inline constexpr int kBits = 52, kLowHalf = 48;

}  // namespace sparse_word

/// Walks over slices of a level. The level must outlive it.
class SparseWalk {
 public:
  static constexpr std::size_t kHugePlanes = std::size_t{8} << 20, kManyNodes = 4096;

  explicit SparseWalk(SliceLevel& level);

  /// Finds the words of a slice, and what the nodes' children inherit. Slices are visited in
  /// increasing order.
  void visit(std::size_t slice);

  /// Of the nodes of the slice that was visited last.
  std::size_t size() const { return size_; }
  std::uint64_t word(std::size_t i) const { return low_[i] | std::uint64_t{high_[i]} << 32; }
  Orientation orientation(std::size_t i) const { return orientations_[i]; }

 private:
  void describe(std::uint32_t begin);

  SliceLevel& level_;
  std::optional<NodePlanes> planes_;  ///< or else, by searching
  NodeSearch search_;
  bool wide_;  ///< whether to use the processor's wider vectors
  std::size_t size_ = 0;
  std::vector<std::uint32_t> cubes_, low_, high_;
  std::vector<Orientation> orientations_;
};

}  // namespace pointreel
