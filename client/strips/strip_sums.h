#pragma once

#include <limits>

#include <glm/glm.hpp>

namespace pointreel {

/// What a node of the tree of strips is described by, besides what it keeps.
struct StripSums {
  // A box around all triangles below.
  glm::vec3 min{std::numeric_limits<float>::max()}, max{std::numeric_limits<float>::lowest()};
  glm::dvec3 positions{0.0};  ///< the sum of those of all surfels below
};

}  // namespace pointreel
