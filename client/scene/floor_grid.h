#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "client/scene/camera.h"
#include "pointreel/geometry.h"

namespace pointreel {

/// A grid of lines on the floor that a scene stands on.
struct FloorGrid {
  Box bounds;   ///< of the scene, in the world; the side that is down is the floor
  Up up = 'y';  ///< of the world

  bool operator==(const FloorGrid&) const = default;
};

/// The distance between neighbouring lines in the scene's units: 1, 2 or 5 times a power of ten. A
/// box that is empty or has no extent is treated as a box of edge 1.
double floor_step(const Box& bounds);

/// The middle of the floor, in the world. Lines are relative to it.
glm::dvec3 floor_origin(const FloorGrid& grid);

/// The part of a line that lies in front of the eye.
struct FloorLine {
  glm::vec3 from, to;  ///< relative to floor_origin
  float strength;      ///< of its colour: lines at whole powers of ten are stronger
  float step;          ///< distance to the next line of the same strength
};

/// The lines of a floor that may appear in the picture. They lie at multiples of floor_step in the
/// world and end at the rim of a disc with radius floor_reach around the origin.
std::vector<FloorLine> floor_lines(const FloorGrid& grid, const Camera& camera);

/// Radius of the disc. The floor fades out towards its rim.
double floor_reach(const Box& bounds);

}  // namespace pointreel
