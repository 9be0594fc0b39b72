#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "client/strips/surfels.h"
#include "codec/surface/cell_neighbors.h"
#include "pointreel/executor.h"

namespace pointreel {

/// When a set of surfels is a patch: few enough, and the graph of a function over a plane
/// (Boubekeur, Reuter and Schlick, "Surfel Stripping", 2005, section 3.3).
struct PatchRule {
  /// The most surfels of a patch. Since an octree divides a surface by four, patches have about 30
  /// with this, in the middle of the paper's range of 20 to 40. With 40 they have 15, three times
  /// as many surfels are added around each of them, and twice as many triangles overlap.
  std::uint32_t most = 90;
  /// The least cosine between the mean normal of a patch and each of its normals. The paper's 0.15
  /// allows 81 degrees; it must mean 1 - 0.15 (common/FORMULAS.md, "Height maps of strips").
  float least_cosine = 0.85f;
  /// The largest distance from the mean plane, as a share of that from the centre.
  float most_height = 0.15f;
  /// Heights that are no larger than this share of the surfels' radii are noise, or the steps of
  /// voxels.
  float noise = 1.0f;

  bool operator==(const PatchRule&) const = default;
};

/// Surfels that belong together: those below one node of the octree.
struct PatchNode {
  std::uint32_t svo_node = 0;
  std::uint32_t parent = 0;          ///< index of a node; the root's is its own
  std::uint32_t begin = 0, end = 0;  ///< the surfels
  std::uint32_t first_child = 0;     ///< index of a node
  std::uint8_t children = 0;         ///< 0 for a patch
  std::uint8_t level = 0;            ///< in the octree
  NodeBlock around{};                ///< nodes of the octree
};

/// The stripping tree: the upper part of the octree, down to the patches. Nodes are in
/// breadth-first order, so that a parent comes before its children, and siblings follow each other.
struct StrippingTree {
  std::vector<PatchNode> nodes;
  std::vector<std::uint32_t> patches;       ///< the nodes without children, by their first surfel
  std::vector<std::uint32_t> first_surfel;  ///< of each node of the octree
  std::vector<std::uint32_t> patch_of;      ///< for each surfel, an index into `patches`

  /// The first surfel below a node of the octree on `level`, and the one after the last.
  std::pair<std::uint32_t, std::uint32_t> surfels_below(const Svo& svo, std::uint32_t node,
                                                        int level) const;
};

/// The mean plane of a set of surfels, in which they are triangulated.
struct PatchPlane {
  glm::vec3 center;
  glm::vec3 normal;  ///< of unit length
};

/// The plane of the surfels from `begin` to `end`. The normal is the mean of their normals, or if
/// there is none, that of the plane through their positions.
PatchPlane patch_plane(const StripSurfels& surfels, std::uint32_t begin, std::uint32_t end);

/// Divides the octree until all sets are patches, or single leaves. O(nodes).
StrippingTree make_stripping_tree(const StripSurfels& surfels, const PatchRule& rule,
                                  const Executor& executor);

}  // namespace pointreel
