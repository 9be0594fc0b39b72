#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "client/render/gl_objects.h"
#include "client/scene/camera.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"

namespace pointreel {

/// A grid of lines on the floor that a scene stands on.
struct FloorGrid {
  Box bounds;     ///< of the scene, in the world; the floor is its lower side
  char up = 'y';  ///< the world's up axis, 'y' or 'z'

  bool operator==(const FloorGrid&) const = default;
};

/// How far apart neighbouring lines are: 1, 2 or 5 times a power of ten, of the scene's units. An
/// empty box, or one without extent, counts as one of edge 1.
double floor_step(const Box& bounds);

/// In the middle of the floor, in the world: what lines are relative to.
glm::dvec3 floor_origin(const FloorGrid& grid);

/// A part of a line that is before the eye.
struct FloorLine {
  glm::vec3 from, to;  ///< relative to floor_origin
  float strength;      ///< of its colour: lines at whole powers of ten are stronger
  float step;          ///< to the next line as strong
};

/// The lines of a floor that may be in the picture. They lie at multiples of floor_step in the
/// world, and end at the rim of a disc of floor_reach around the origin.
std::vector<FloorLine> floor_lines(const FloorGrid& grid, const Camera& camera);

/// Radius of the disc: the floor fades out towards it.
double floor_reach(const Box& bounds);

/// Draws floors. There is nothing below a floor, so whether it hides the scene or the scene it
/// depends only on the side on which the eye is: from above it is drawn before the scene, from
/// below after it. Either is right with any way to draw the scene, and whatever that leaves as
/// depth.
class Floor {
 public:
  Floor();

  /// Into the bound framebuffer, whose viewport is set, as are the View block of common.glsl, for
  /// coordinates relative to floor_origin, and the encoding as sRGB. `background` (sRGB) decides
  /// whether lines are light or dark. Alpha and depth stay as they are. Blending and the depth test
  /// are off afterwards.
  Result<void> draw(const FloorGrid& grid, const Camera& camera, const glm::vec3& background);

 private:
  gl::LateProgram program_;
  gl::Buffer lines_;
  std::size_t capacity_ = 0;  ///< of the buffer, in lines
  gl::VertexArray array_;
};

}  // namespace pointreel
