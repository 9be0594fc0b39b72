#pragma once

#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "pointreel/error.h"

namespace pointreel {

/// The tangents of a surfel.
struct SurfelFrame {
  glm::vec3 u, v;
};

/// The tangents that the shaders compute for unit normals: runs `surfel_frame` of
/// instancing/shaders/surfel.glsl in a compute shader, in an offscreen context of its own. Fails if
/// there is no OpenGL 4.5.
Result<std::vector<SurfelFrame>> surfel_frames(std::span<const glm::vec3> normals);

}  // namespace pointreel
