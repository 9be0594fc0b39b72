#pragma once

#include <cstddef>

#include "pointreel/cloud.h"

namespace pointreel {

/// The bytes of a cloud's arrays, without what is reserved.
inline std::size_t memory_of(const PointCloud& cloud) {
  return cloud.positions.size() * sizeof(glm::vec3) + cloud.normals.size() * sizeof(glm::vec3) +
         cloud.colors.size() * sizeof(glm::u16vec3) + cloud.radii.size() * sizeof(float) +
         cloud.scalars.size() * cloud.size() * sizeof(float);
}

}  // namespace pointreel
