#pragma once

#include <cmath>

#include <glm/glm.hpp>

namespace pointreel {

/// The vector v, which must not be zero, with length 1. glm::normalize rounds differently, and
/// synthetic sequences must keep their bytes.
inline glm::dvec3 unit(const glm::dvec3& v) { return v / std::sqrt(glm::dot(v, v)); }

}  // namespace pointreel
