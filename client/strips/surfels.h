#pragma once

#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "pointreel/octree.h"

namespace pointreel {

/// Surfels to be stripped: one for each leaf of a tree, in the order of the leaves. A surfel's
/// index is its leaf's.
struct StripSurfels {
  const Svo& svo;
  std::span<const glm::vec3> positions;  ///< relative to the cube's origin
  std::span<const glm::vec3> normals;    ///< of unit length, or zero where unknown
  std::span<const float> radii;          ///< such that discs of these radii cover the surface
  bool lines = false;                    ///< the signs of the normals are unknown
};

}  // namespace pointreel
