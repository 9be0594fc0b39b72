#pragma once

#include <cstddef>

#include <glm/glm.hpp>

#include "client/render/opengl/gl_objects.h"
#include "client/scene/camera.h"
#include "client/scene/floor_grid.h"
#include "pointreel/error.h"

namespace pointreel {

/// Draws floors. Nothing lies below a floor, so which hides which depends only on the side of the
/// eye: seen from above, the floor is drawn before the scene; seen from below, after it. That holds
/// for every way to draw the scene, and needs none of the depths that it leaves.
class Floor {
 public:
  Floor();

  /// Draws into the bound framebuffer. The caller has set the viewport, the encoding as sRGB, and
  /// the View block of common.glsl for coordinates relative to floor_origin. `background` (sRGB)
  /// decides whether the lines are light or dark. Alpha and depth stay as they are. Blending and
  /// the depth test are off afterwards.
  Result<void> draw(const FloorGrid& grid, const Camera& camera, const glm::vec3& background);

 private:
  gl::LateProgram program_;
  gl::Buffer lines_;
  std::size_t capacity_ = 0;  ///< of lines_, in lines
  gl::VertexArray array_;
};

}  // namespace pointreel
