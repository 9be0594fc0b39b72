#pragma once

#include <glm/glm.hpp>

#include "pointreel/cloud.h"

namespace pointreel {

/// How a source's coordinates become those of a reel: scaled, then rotated about zero.
struct Placement {
  double scale = 1.0;        ///< above 0
  glm::dmat3 rotation{1.0};  ///< orthonormal, without a mirror

  bool moves() const { return scale != 1.0 || rotation != glm::dmat3(1.0); }
};

/// Rotates about the fixed axes x, then y, then z, counterclockwise as seen from their tips, as
/// Blender's "XYZ Euler" does. Multiples of 90 degrees are exact.
glm::dmat3 rotation_of(const glm::dvec3& degrees);

/// Moves all points, and what belongs to them: normals turn, and radii grow.
void place(PointCloud& cloud, const Placement& placement);

}  // namespace pointreel
