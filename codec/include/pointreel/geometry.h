#pragma once

#include <limits>

#include <glm/glm.hpp>

namespace pointreel {

/// An axis-aligned box in world coordinates, in the units of the source. Empty until it is grown.
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

/// The cube that an octree divides, in world coordinates.
struct Cube {
  glm::dvec3 origin{0.0};  ///< the corner with the smallest coordinates
  double edge = 1.0;       ///< > 0, finite

  bool operator==(const Cube&) const = default;
};

/// The smallest cube that holds `box` and shares its minimum corner; its edge is 1 if the box has
/// no extent. FORMULAS.md, "Cube of a frame".
Cube bounding_cube(const Box& box);

/// A cube and the depth at which its cells have a given size.
struct VoxelCube {
  Cube cube;
  int depth = 0;  ///< above kMaxDepth (octree.h) if the voxels are too small for an octree
};

/// The cube that holds `box` and whose cells at the returned depth have the size `voxel` (> 0) and
/// are centred on multiples of it: points that lie on that grid decode to themselves.
VoxelCube voxel_cube(const Box& box, double voxel);

}  // namespace pointreel
