#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "client/strips/patches.h"
#include "client/strips/strip_order.h"
#include "client/strips/stripping_tree.h"
#include "client/strips/surfels.h"
#include "pointreel/executor.h"
#include "pointreel/octree.h"

namespace pointreel {

/// A node of the tree that strips are culled by. Coordinates are those of the surfels.
struct StripNode {
  /// A sphere around all triangles below.
  glm::vec3 center{0.0f};
  float radius = 0.0f;
  /// A cone that holds the normals of all triangles below. A cosine of -1 stands for any normals.
  glm::vec3 axis{0.0f};
  float cosine = -1.0f;
  /// The node is the root, or its index is within its parent's children. Patches have none.
  std::uint32_t first_child = 0, children = 0;
  /// The strips of all patches below: a range of SurfelStrips::indices.
  std::uint32_t first_index = 0, indices = 0;
  std::uint32_t triangles = 0;
  // The representative surfel: the means of all surfels below.
  glm::vec3 position{0.0f};
  glm::i16vec3 normal{0};  ///< of length 32767, or zero where unknown
  glm::u16vec3 color{0};   ///< sRGB, as PointCloud::colors; 0 if there are none

  bool operator==(const StripNode&) const = default;
};

/// Surfels as a surface of small triangle strips. T. Boubekeur, P. Reuter, C. Schlick, "Surfel
/// Stripping", 2005. The vertices are the surfels themselves.
struct SurfelStrips {
  std::vector<StripNode> nodes;        ///< the root first; children follow their parents
  std::vector<std::uint32_t> indices;  ///< of surfels; strips end with kEndOfStrip

  bool empty() const { return indices.empty(); }
  bool operator==(const SurfelStrips&) const = default;
};

struct StripRules {
  PatchRule patch;
  InflationRule inflation;

  bool operator==(const StripRules&) const = default;
};

/// Makes strips of surfels, whose tree has these attributes. The result does not depend on the
/// executor. O(n) for surfels on a surface. Throws nothing but std::bad_alloc.
SurfelStrips make_strips(const StripSurfels& surfels, const NodeAttributes& attributes,
                         const StripRules& rules = {}, const Executor& executor = {});

/// What strips were made of, kept to make those of a similar frame faster.
struct StripRecord;

struct RecordedStrips {
  SurfelStrips strips;
  std::shared_ptr<const StripRecord> record;
  std::uint32_t made = 0;  ///< the patches whose strips were made, not taken from a record
};

/// The same strips as those of make_strips, and a record of them. Only patches are made again
/// around which surfels differ from those of the record, which may be any frame's, or null. Trees
/// of other cubes or depths have nothing in common. A record takes about as much memory as three
/// frames.
RecordedStrips update_strips(const StripSurfels& surfels, const NodeAttributes& attributes,
                             const std::shared_ptr<const StripRecord>& before,
                             const StripRules& rules = {}, const Executor& executor = {});

}  // namespace pointreel
