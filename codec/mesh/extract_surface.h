#pragma once

#include <cstdint>
#include <vector>

#include "codec/core/triangle_mesh.h"
#include "codec/mesh/local_surface.h"
#include "pointreel/error.h"
#include "pointreel/executor.h"

namespace pointreel {

/// A mesh that reaches a little beyond the boundaries of its surface.
struct UncutMesh {
  TriangleMesh mesh;
  std::vector<float> beside;  ///< for each vertex, as in SurfaceFits
};

/// The surface of the points where it crosses the edges of the grid, with a vertex for each patch
/// of a cell: dual marching cubes. Every vertex is moved onto the surface of the points. No edge is
/// longer than two diagonals of a cell. The mesh does not depend on the executor.
/// Error: `limit` if it would take more than `max_memory` bytes.
Result<UncutMesh> extract_surface(const GriddedCloud& points, std::uint64_t max_memory,
                                  const Executor& executor);

}  // namespace pointreel
