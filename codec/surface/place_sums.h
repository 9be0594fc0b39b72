#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "codec/surface/algebraic_sphere.h"
#include "codec/surface/lanes.h"
#include "codec/surface/point_rows.h"

namespace pointreel {

/// Places near each other at which a surface is evaluated at once, one in each lane.
struct alignas(sizeof(Lanes)) Places {
  Lanes x{}, y{}, z{};
  Lanes nx{}, ny{}, nz{};     ///< only points with about this normal count
  Lanes per_square{};         ///< 1 / radius^2
  float least_cosine = 0.0f;  ///< of the angle between both normals
};

/// Weighted sums over the points around each place, relative to it: those of `SphereSums`.
struct alignas(sizeof(Lanes)) PlaceSums {
  Lanes w{}, px{}, py{}, pz{}, nx{}, ny{}, nz{}, pp{}, pn{};

  SphereSums at(std::size_t lane) const;
};

/// Weighted sums of the products of coordinates, which tell how far points extend in each
/// direction.
struct alignas(sizeof(Lanes)) PlaceMoments {
  Lanes xx{}, yy{}, zz{}, xy{}, yz{}, zx{};
};

/// Where the surface is nearest to some points.
struct alignas(sizeof(Lanes)) PlacesFound {
  Lanes x{}, y{}, z{};     ///< relative to the places
  Lanes nx{}, ny{}, nz{};  ///< of the surface there, of unit length
  LaneMask found{};        ///< whether there is a surface
};

/// Writes the numbers of those points of the candidate rows that are in a ball to the beginning of
/// `near`, which grows if needed. Returns how many there are.
std::size_t select_points(std::span<const PointRow> rows, std::span<const std::uint32_t> candidates,
                          const glm::vec3& center, float radius, std::vector<std::uint32_t>& near);

/// Sums over those of the points that are `near`. A point at the distance d has the weight
/// (1 - d^2 / radius^2)^4, or 0 where the normals differ too much. Fills `moments`
/// unless that is null. The same to the bit on every processor.
PlaceSums sum_around(std::span<const PointNormal> points, std::span<const std::uint32_t> near,
                     const Places& places, PlaceMoments* moments = nullptr);

/// `fit_sphere` and `AlgebraicSphere::project` for all places at once, in single precision.
/// `fx`, ...: the points to project, relative to the places.
PlacesFound project_onto_spheres(const PlaceSums& sums, float beta, const Lanes& fx,
                                 const Lanes& fy, const Lanes& fz);

/// The matrix of the second moments of weighted points: the sum of w p p^T.
class SecondMoments {
 public:
  SecondMoments(const PlaceMoments& moments, std::size_t lane);

  /// About the mean, instead of about zero. `p`: the sum of w p; `w`: the sum of w.
  SecondMoments around(const glm::dvec3& p, double w) const;
  /// The smaller of the two principal moments within the plane with this normal.
  double least_along(const glm::dvec3& normal) const;
  /// The axis of the smallest principal moment, on the side of `normal`; nothing if the points lie
  /// on a line or all on one spot.
  std::optional<glm::dvec3> least_axis(const glm::dvec3& normal) const;

 private:
  SecondMoments() = default;
  glm::dmat3 cofactors() const;

  double xx_ = 0.0, yy_ = 0.0, zz_ = 0.0, xy_ = 0.0, yz_ = 0.0, zx_ = 0.0;
};

}  // namespace pointreel
