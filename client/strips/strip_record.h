#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "client/strips/patches.h"
#include "client/strips/strip_sums.h"
#include "client/strips/stripping_tree.h"
#include "client/strips/strips.h"
#include "client/strips/surfels.h"

namespace pointreel {

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
