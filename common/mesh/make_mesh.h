#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/mesh/triangle_mesh.h"
#include "pointreel/executor.h"

namespace pointreel {

struct MeshOptions {
  /// The edge of the cells in which the surface is looked for, in the units of the cloud: about the
  /// length of the mesh's edges. Absent: kCellSpacings times the spacing of the points.
  std::optional<double> cell = std::nullopt;
  /// At most so many triangles, where the shape of the surface allows that. Absent: all.
  std::optional<std::size_t> triangles = std::nullopt;
};

/// MeshOptions::cell, unless given.
inline constexpr double kCellSpacings = 1.5;

/// About how much memory make_mesh takes for each point with the default cell.
inline constexpr std::uint64_t kMeshBytesPerPoint = 700;

/// The surface that the points are samples of: an algebraic point set surface
/// (surface/point_surface.h), as a mesh by dual marching cubes. It ends at the boundary of what was
/// scanned, and gaps of less than about four spacings are closed. Small specks are left out. The
/// mesh is empty if no surface goes through the points, as if there are only a few.
///
/// Normals tell the two sides of the surface apart; they are estimated where points have none
/// (normals.h). Sheets that are closer together than about the cell's edge may merge or break.
///
/// The cloud's positions are finite (`sanitize`). The result does not depend on the executor, nor,
/// but for rounding errors, on the order of the points. Time and memory are linear in the number of
/// points.
TriangleMesh make_mesh(PointCloud cloud, const MeshOptions& options = {},
                       const Executor& executor = {});

}  // namespace pointreel
