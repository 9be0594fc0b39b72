#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "codec/core/build.h"
#include "codec/surface/cell_neighbors.h"
#include "codec/surface/point_rows.h"
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

/// How well the points around a place tell where the surface is.
struct SurfaceEvidence {
  float square = 0.0f;  ///< of the distance between the point and the surface
  float weight = 0.0f;  ///< the sum of the weights; 0: no surface, or not measured
  /// How far the points extend along the surface in the direction in which that is least: the mean
  /// square, over that of the radius. 1/12 where points cover the surface evenly, about 0 on a
  /// line.
  float extent = 0.0f;
  /// Half the square of the step across the surface from the point to one of its nearest
  /// neighbours: what `square` is on average if the noise of points is their own.
  float neighbor_square = 0.0f;
};

/// The sphere that fits the surface around a point, and the points around it.
struct SurfacePatch {
  static constexpr std::size_t kMostNeighbors = 64;

  glm::vec3 position{0.0f};  ///< on the surface, relative to the cloud's origin
  glm::vec3 normal{0.0f};    ///< of unit length; zero: no surface, or none was fitted
  float curvature = 0.0f;    ///< 1 over the radius, above 0 where the centre is behind the surface
  /// The nearest other points on the same side of the surface, as numbers in order().
  std::array<std::uint32_t, kMostNeighbors> neighbors;
  std::uint32_t neighbor_count = 0;
};

/// The surface that a cloud of points with normals stands for: the algebraic point set surface of
/// G. Guennebaud, M. Germann, M. Gross, "Dynamic Sampling and Rendering of Algebraic Point Set
/// Surfaces", 2008, with spheres that are fitted directly (algebraic_sphere.h). A point p has the
/// weight (1 - |p - x|^2 / r^2)^4 at a place x, where r is the radius of support of that place, and
/// 0 if its normal differs too much from the surface's, so that sheets close together stay apart.
///
/// Points whose normal is zero take no part in the surface. O(n log n) to make; the neighbours come
/// from an octree. `radii` and all results are in order(). A radius of 0 leaves a point out. The
/// work for one place is bounded: where more than some thousand points are near, only a part of
/// them counts.
class PointSurface {
 public:
  /// The cloud's positions are finite, and it has normals. The surface does not refer to it.
  explicit PointSurface(const PointCloud& cloud, const Executor& executor = {});

  /// The number of the cloud's point that is the i-th in Morton order.
  std::span<const KeyIndex> order() const { return sorted_.points; }

  /// For each point, a radius within which there are about `points` points. It is estimated from
  /// the octree, and within a factor of 1.5 or so.
  std::vector<float> radii_of(double points) const;

  /// Measures the surface around one in `one_in` points, in groups of neighbours.
  std::vector<SurfaceEvidence> measure(std::span<const float> radii, double beta,
                                       std::uint32_t one_in, const Executor& executor = {}) const;

  /// Replaces the normal of each point by that of the plane that fits the positions around it best,
  /// on the same side. Normals that come with a cloud were often estimated from too few points.
  void fit_normals(std::span<const float> radii, const Executor& executor = {});

  /// Projects each point onto the surface: `steps` times, the sphere is fitted where the last step
  /// led, and the point where it began goes to the sphere ("almost orthogonal projection", section
  /// 4.2). A step that leads further away than the radius is not taken, and the point then has no
  /// surface.
  /// `normals`: of the places, for points that have none because they take no part; empty: those of
  /// the points.
  std::vector<SurfaceSample> project(std::span<const float> radii, double beta, int steps,
                                     const Executor& executor = {},
                                     std::span<const glm::vec3> normals = {}) const;

  /// Fits the surface around the points that have a radius. `slots`: where the patches of these
  /// points are in `patches`; the others' patches stay as they are.
  void fit_patches(std::span<const float> radii, double beta, std::span<const std::uint32_t> slots,
                   std::span<SurfacePatch> patches, const Executor& executor = {}) const;

  /// The means of `values` around each point, with the weights of the surface. Points whose normal
  /// is more than a right angle away do not count.
  /// `normals`: as above.
  std::vector<glm::vec3> weighted_means(std::span<const float> radii,
                                        std::span<const glm::vec3> values,
                                        const Executor& executor = {},
                                        std::span<const glm::vec3> normals = {}) const;

  /// The means of `values` around each point: over the smallest octree cell that, together with the
  /// cells around it, has at least `points` of them. Values whose first number is negative do not
  /// count.
  std::vector<glm::vec3> local_means(std::span<const glm::vec3> values, std::size_t points) const;

 private:
  /// The rows of a node of the octree, which have most of the points around them in common.
  struct Group {
    std::uint32_t node;
    float radius;  ///< the largest of its points
  };
  struct Nearby;
  struct RowPlaces;
  struct Node {
    std::uint32_t begin, end;  ///< its points, in order()
    std::uint32_t parent;
    glm::vec3 corner;  ///< the minimum, in the coordinates of points_
    float edge;
    std::uint32_t first_row = 0, end_row = 0;  ///< that hold its points, and maybe others
  };

  void make_rows();
  std::uint32_t child_count(std::uint32_t node) const;
  std::vector<Group> groups(std::span<const float> radii) const;
  void gather(const Group& group, Nearby& nearby) const;
  template <class Enough, class Done>
  void for_smallest_blocks(const Enough& has_enough, const Done& done) const;
  template <class Work>
  void for_each_row(std::span<const float> radii, std::uint32_t one_in, const Executor& executor,
                    const Work& work) const;

  SortedPoints sorted_;
  Svo svo_;
  std::vector<NodeBlock> blocks_;
  std::vector<Node> nodes_;
  glm::dvec3 offset_{0.0};  ///< from the cube's centre, the zero of points_, to the cloud's
  std::vector<PointNormal> points_;  ///< in order()
  std::vector<PointRow> rows_;
};

}  // namespace pointreel
