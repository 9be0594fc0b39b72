#pragma once

#include <cstdint>
#include <vector>

#include "client/strips/surfels.h"
#include "codec/surface/cell_neighbors.h"
#include "pointreel/executor.h"

namespace pointreel {

/// What is the same in two sets of surfels, such as those of successive frames. Surfels are the
/// same if they lie in the same leaf and their positions, normals and radii are equal to the bit.
/// Both trees have the same cube and depth.
class SurfelChanges {
 public:
  /// O(nodes).
  SurfelChanges(const StripSurfels& before, const StripSurfels& now, const Executor& executor);

  /// The node that was where a node of the octree is now; kNoNode if none was.
  std::uint32_t node_before(std::uint32_t node) const { return node_before_[node]; }
  /// Whether a node was there before and all surfels below it are the same.
  bool same(std::uint32_t node) const { return same_[node] != 0; }
  /// Whether all surfels are the same, and there are no others.
  bool none() const { return !same_.empty() && same_[0] != 0; }
  /// The index that a surfel has now. Only for those that are the same.
  std::uint32_t surfel_now(std::uint32_t before) const { return surfel_now_[before]; }

 private:
  void match_nodes(const Svo& before, const Svo& now);

  std::vector<std::uint32_t> node_before_;
  std::vector<std::uint8_t> same_;
  std::vector<std::uint32_t> surfel_now_;
};

}  // namespace pointreel
