#pragma once

#include <limits>

#include <glm/glm.hpp>


namespace pointreel {

/// Axis-aligned box in world coordinates (the source's units, double). Empty until it is grown.
struct Box {
  glm::dvec3 min{std::numeric_limits<double>::infinity()};
  glm::dvec3 max{-std::numeric_limits<double>::infinity()};

  bool empty() const { return !(min.x <= max.x); }
  glm::dvec3 extent() const { return empty() ? glm::dvec3(0.0) : max - min; }
  glm::dvec3 center() const { return empty() ? glm::dvec3(0.0) : 0.5 * (min + max); }
  void grow(const glm::dvec3& p) {
    min = glm::min(min, p);
    max = glm::max(max, p);
  }
  void grow(const Box& other) {
    min = glm::min(min, other.min);
    max = glm::max(max, other.max);
  }
  bool operator==(const Box&) const = default;
};

/// The cube that an octree divides: its minimum corner and its edge (> 0, finite), in world
/// coordinates.
struct Cube {
  glm::dvec3 origin{0.0};
  double edge = 1.0;

  bool operator==(const Cube&) const = default;
};

/// The smallest cube that holds `box`, anchored at its minimum corner; edge 1 where the box has no
/// extent. Paper 2, section VI-A, leaves the anchor open; this is ERRATA 12's choice.
Cube bounding_cube(const Box& box);

/// The cube whose cells at the returned depth have the size `voxel` and are centred on multiples of
/// it, so that input which lies on that grid comes back exactly.
struct VoxelCube {
  Cube cube;
  int depth = 0;  ///< may exceed kMaxDepth (morton.h) where the voxel is too small: check it
};
VoxelCube voxel_cube(const Box& box, double voxel);

}  // namespace pointreel
