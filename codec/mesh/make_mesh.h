#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "codec/core/triangle_mesh.h"
#include "pointreel/error.h"
#include "pointreel/executor.h"

namespace pointreel {

struct MeshOptions {
  /// The edge of the cells in which the surface is looked for, in the units of the cloud: about the
  /// length of the mesh's edges, and at least half the spacing of the points. Absent: kCellSpacings
  /// times the spacing.
  std::optional<double> cell = std::nullopt;
  /// At most so many triangles, where the shape of the surface allows that. Absent: all.
  std::optional<std::size_t> triangles = std::nullopt;
  /// The memory that the grid may take, in bytes; a surface of evenly spread points needs about 600
  /// for each.
  std::uint64_t max_memory = ~std::uint64_t{0};
};

/// MeshOptions::cell, unless given.
inline constexpr double kCellSpacings = 1.5;

/// The surface that the points are samples of: an algebraic point set surface
/// (surface/point_surface.h), as a mesh by dual marching cubes. It ends at the boundary of what was
/// scanned, and gaps of less than about four spacings are closed. Small specks are left out. The
/// mesh is empty if no surface goes through the points, as if there are only a few.
///
/// Normals tell the two sides of the surface apart; they are estimated where points have none
/// (normals.h). Sheets that are closer together than about the cell's edge may merge or break.
///
/// The cloud's positions are finite (`sanitize`). The result does not depend on the executor. Time
/// is linear in the number of points. Error: `limit` if more memory would be needed.
Result<TriangleMesh> make_mesh(PointCloud cloud, const MeshOptions& options = {},
                               const Executor& executor = {});

}  // namespace pointreel
