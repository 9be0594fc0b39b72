#pragma once

#include <glm/glm.hpp>

namespace pointreel {

/// The tangents of a surfel; (u, v, n) is orthonormal and right-handed.
struct SurfelFrame {
  glm::vec3 u, v;
};

/// The frame of a unit normal, paper 2, section V-A, corrected: the paper's v = n x a is -u
/// (ERRATA 1), and "not parallel" needs a tolerance (ERRATA 3). The surfel's corner (x, y) then is
/// p + r (x u + y v) (ERRATA 2).
///
/// instancing/shaders/surfel.glsl holds the same function, line for line; this one is for tests and
/// for whoever needs the frame on the CPU. Change both.
inline SurfelFrame surfel_frame(const glm::vec3& n) {
  const bool at_pole = n.x * n.x + n.z * n.z < 1e-12f;
  const glm::vec3 a = at_pole ? glm::vec3(0.0f, 0.0f, -1.0f) : glm::vec3(0.0f, 1.0f, 0.0f);
  const glm::vec3 u = glm::normalize(glm::cross(a, n));
  return {u, glm::cross(n, u)};
}

}  // namespace pointreel
