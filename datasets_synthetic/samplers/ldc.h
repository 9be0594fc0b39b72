#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "datasets_synthetic/samplers/uniform.h"
#include "datasets_synthetic/surface_grid.h"
#include "pointreel/error.h"

namespace pointreel {

/// A lattice of parallel rays: point (i, j, k) is at origin + spacing * (i, j, k), and every line
/// along an axis through points of the lattice is a ray.
struct Lattice {
  glm::dvec3 origin{0.0};
  double spacing = 0.004;  ///< metres; > 0, finite
};

/// A point where a ray along `axis` passes through the surface.
struct LatticeHit {
  SurfacePoint point;  ///< its coordinates across `axis` are those of the ray
  int axis = 0;
  glm::ivec3 cell{0};  ///< the hit is on the edge that starts at this lattice point, along `axis`
};

/// A layered depth cube (Pfister et al., Surfels, section 5.1): three orthogonal layered depth
/// images with every hit of every ray, including those where a ray leaves the body. Sorted by image
/// (rays along x, y, z), then by ray, then along the ray. The result depends on the arguments only.
///
/// Every point of the surface is within sqrt(3) / 2 spacings of a hit (FORMULAS.md, "Layered depth
/// cube"). Exceptions are structures, and tips of the surface between creases, that are thinner
/// than the spacing: they may fit between the rays. There are about 1.5 area / spacing^2 hits.
///
/// Fails if the spacing is not above 0, or so small that there would be 2^31 rays or more.
Result<std::vector<LatticeHit>> cast_lattice(const SurfaceGrid& grid, const Lattice& lattice);

struct LdcOptions {
  double spacing = 0.004;  ///< metres between rays; h0 in the paper
  /// 3-to-1 reduction (Pfister et al., Surfels, section 6.2): every hit moves along its ray to the
  /// nearest point of the lattice, and of the hits that meet there only the one that moved least
  /// remains. No two points are closer to each other than the spacing, and none is further than
  /// half of it from the surface.
  bool reduce = false;
};

/// The reduction works on blocks with this many lattice points along each edge. A block in which
/// two sides of the body would meet at one lattice point is not reduced, as the paper suggests for
/// thin structures.
inline constexpr int kLdcBlock = 16;

/// The points of a layered depth cube with the true normals of the surface. The lattice contains
/// the world's origin, so it is the same for all poses.
Result<std::vector<SurfacePoint>> sample_ldc(const SurfaceGrid& grid, const LdcOptions& options);

}  // namespace pointreel
