#pragma once

#include <limits>
#include <vector>

#include <glm/glm.hpp>

#include "client/strips/patches.h"
#include "client/strips/stripping_tree.h"
#include "client/strips/strips.h"
#include "client/strips/surfels.h"

namespace pointreel {

/// What a node of the tree of strips is described by, besides what it keeps.
struct StripSums {
  // A box around all triangles below.
  glm::vec3 min{std::numeric_limits<float>::max()}, max{std::numeric_limits<float>::lowest()};
  glm::dvec3 positions{0.0};  ///< the sum of those of all surfels below
};

/// What update_strips keeps of a frame, to make only the strips around what the next one changes.
struct StripRecord {
  StripRules rules;
  // The surfels (StripSurfels).
  Svo svo;
  std::vector<glm::vec3> positions, normals;
  std::vector<float> radii;
  bool lines = false;

  StrippingTree tree;
  Patches patches;
  SurfelStrips strips;
  std::vector<StripSums> sums;  ///< of each node of the stripping tree

  StripSurfels surfels() const { return {svo, positions, normals, radii, lines}; }
};

}  // namespace pointreel
