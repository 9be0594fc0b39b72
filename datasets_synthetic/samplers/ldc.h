#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "datasets_synthetic/samplers/uniform.h"
#include "datasets_synthetic/surface_grid.h"
#include "pointreel/error.h"

namespace pointreel {

/// Parallel rays: the point (i, j, k) of a lattice is at origin + spacing * (i, j, k), and every
/// line along an axis through points of the lattice is a ray.
struct Lattice {
  glm::dvec3 origin{0.0};
  double spacing = 0.004;  ///< metres; > 0, finite
};

/// Where a ray along `axis` passes through the surface.
struct LatticeHit {
  SurfacePoint point;  ///< its other two coordinates are those of the ray
  int axis = 0;
  glm::ivec3 cell{0};  ///< of the lattice: the hit is on the edge from `cell` on along `axis`
};

/// A layered depth cube (001, section 5.1): three orthogonal layered depth images, every hit of
/// every ray, those that leave the body included. By image (rays along x, y, z), and in it by ray
/// and along it. A function of its arguments alone.
///
/// Every point of the surface is within sqrt(3) / 2 spacings of a hit (ERRATA 27: sqrt(3) is the
/// longest edge between neighbours, the cover radius is half of it). The exception is what no ray
/// meets because it fits between them: structures, and tips of the surface between creases, that
/// are thinner than the spacing. About 1.5 area / spacing^2 hits.
///
/// Fails where the spacing gives more than 2^31 rays or coordinates that are not finite.
Result<std::vector<LatticeHit>> cast_lattice(const SurfaceGrid& grid, const Lattice& lattice);

struct LdcOptions {
  double spacing = 0.004;  ///< h0, metres between pixels
  /// 3-to-1 reduction (001, section 6.2): every hit moves along its ray to the nearest point of the
  /// lattice, and of those that meet there one stays, the one that moved least. No two points are
  /// nearer to each other than the spacing, and none is further than half of it from the surface.
  bool reduce = false;
};

/// Blocks of so many lattice points along each edge are reduced or, where two sides of the body
/// would meet in a point of the lattice, kept as they are, as the paper suggests for thin
/// structures.
inline constexpr int kLdcBlock = 16;

/// The cube as points with the surface's own normals. The lattice is anchored at the world's zero:
/// the same for all poses.
Result<std::vector<SurfacePoint>> sample_ldc(const SurfaceGrid& grid, const LdcOptions& options);

}  // namespace pointreel
