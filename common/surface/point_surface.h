#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "common/octree/build.h"
#include "common/surface/cell_neighbors.h"
#include "pointreel/cloud.h"
#include "pointreel/executor.h"
#include "pointreel/octree.h"

namespace pointreel {

/// How a point lies to the surface around it. Lengths are in the units of the cloud.
struct SurfaceSample {
  glm::vec3 position{0.0f};  ///< on the surface, relative to the cloud's origin
  glm::vec3 normal{0.0f};    ///< of the surface, of unit length; zero if it is unknown
  float weight = 0.0f;       ///< the sum of the weights of the points around it; 0: no surface
};

/// The surface that a cloud of points with normals stands for: the algebraic point set surface of
/// G. Guennebaud, M. Germann, M. Gross, "Dynamic Sampling and Rendering of Algebraic Point Set
/// Surfaces", 2008, with spheres that are fitted directly (algebraic_sphere.h). A point p has the
/// weight (1 - |p - x|^2 / r^2)^4 at a place x, where r is the radius of support of that place, and
/// 0 if its normal and the surface's differ by more than 72 degrees, so that sheets close together
/// stay apart.
///
/// Points whose normal is zero take no part in the surface. O(n) to make; the neighbours come from
/// an octree.
class PointSurface {
 public:
  /// The cloud's positions are finite, and it has normals. The surface does not refer to it.
  explicit PointSurface(const PointCloud& cloud);

  /// The number of the cloud's point that is the i-th in Morton order. All arrays below are in that
  /// order, in which neighbours are near each other in memory.
  std::span<const KeyIndex> order() const { return sorted_.points; }

  /// For each point, a radius within which there are about `points` points. It is estimated from
  /// the octree, and within a factor of 1.5 or so.
  std::vector<float> radii_of(double points) const;

  /// Projects each point onto the surface: `steps` times, the sphere is fitted where the last step
  /// led, and the point where it began goes to the sphere ("almost orthogonal projection", section
  /// 4.2). A step that leads further away than the radius is not taken, and the point then has no
  /// surface. A radius of 0 leaves a point out. `radii` and the result are in order(). The work for
  /// one place is bounded: where more than some thousand points are near, only a part of them
  /// counts.
  std::vector<SurfaceSample> project(std::span<const float> radii, double beta, int steps,
                                     const Executor& executor = {}) const;

  /// The mean of `values` (in order()) around each point: over the smallest octree cell that,
  /// together with the cells around it, has at least `points` points. Points with a negative value
  /// do not count.
  std::vector<float> local_mean(std::span<const float> values, std::size_t points) const;

 private:
  /// The points of a node of the octree, and those that may be near them.
  struct Group {
    std::uint32_t node;
    float radius;  ///< the largest of its points
  };
  struct Candidates;
  struct Node {
    std::uint32_t begin, end;  ///< its points, in order()
    std::uint32_t parent;
    glm::vec3 corner;  ///< the minimum, in the coordinates of positions_
    float edge;
  };

  std::vector<Group> groups(std::span<const float> radii) const;
  void gather(const Group& group, Candidates& into) const;
  void project(const Group& group, std::span<const float> radii, double beta, int steps,
               Candidates& candidates, std::span<SurfaceSample> samples) const;

  SortedPoints sorted_;
  Svo svo_;
  std::vector<NodeBlock> blocks_;
  std::vector<Node> nodes_;
  glm::dvec3 offset_{0.0};  ///< from the cube's centre, the zero of positions_, to the cloud's
  std::vector<glm::vec3> positions_, normals_;  ///< in order()
};

}  // namespace pointreel
