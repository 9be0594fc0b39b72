#include "codec/mesh/make_mesh.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "codec/core/keep_points.h"
#include "codec/mesh/close_holes.h"
#include "codec/mesh/cut_border.h"
#include "codec/mesh/extract_surface.h"
#include "codec/mesh/point_blocks.h"
#include "codec/mesh/simplify.h"
#include "codec/mesh/tidy.h"
#include "codec/surface/normals.h"
#include "codec/surface/point_surface.h"
#include "common/base/median.h"
#include "common/base/try.h"
#include "pointreel/geometry.h"

namespace pointreel {
namespace {

/// Around how many points their spacing is measured.
constexpr double kCounted = 16.0;
/// Smaller cells would show no more.
constexpr double kLeastSpacings = 0.5;
/// Points are seen within so many cells, and further where they are sparser than elsewhere: up to
/// kMostReach cells.
constexpr float kReach = 2.5f;
constexpr float kMostReach = 6.0f;
/// Counting tells the spacing within about this factor, so that points with less are not sparse.
constexpr float kSparse = 1.3f;
/// Parts with fewer triangles are specks.
constexpr std::size_t kLeastTriangles = 40;
/// Holes with so many edges are narrower than the gaps between points that the surface crosses.
constexpr std::size_t kMostHoleEdges = 16;
/// Cells along an edge of the grid: float coordinates within the cloud tell as many apart.
constexpr double kMostCells = 1 << 20;
/// The grid begins so many cells before the first point.
constexpr double kMargin = 8.0;
constexpr double kPi = 3.14159265358979;

std::vector<float> spacings_of(const PointCloud& cloud) {
  const PointSurface surface(cloud);
  const std::vector<float> radii = surface.radii_of(kCounted);
  std::vector<float> spacings(cloud.size());
  for (std::size_t i = 0; i < radii.size(); ++i) {
    spacings[surface.order()[i].index] = radii[i] * static_cast<float>(std::sqrt(kPi / kCounted));
  }
  return spacings;
}

}  // namespace

Result<TriangleMesh> make_mesh(PointCloud cloud, const MeshOptions& options,
                               const Executor& executor) {
  complete_normals(cloud, executor);
  keep_points(cloud, [&](std::size_t i) { return cloud.normals[i] != glm::vec3(0.0f); });
  if (cloud.size() < 3) return TriangleMesh{};
  const std::vector<float> spacings = spacings_of(cloud);
  const Box box = bounds(cloud);
  const double extent = bounding_cube(box).edge;
  const double spacing = std::max(double{median(spacings)}, 0.0);
  const double cell = std::max({options.cell.value_or(kCellSpacings * spacing),
                                kLeastSpacings * spacing, extent / kMostCells});
  const MeshGrid grid{box.min - cloud.origin - kMargin * cell, cell};
  std::vector<float> reaches(cloud.size());
  for (std::size_t i = 0; i < reaches.size(); ++i) {
    const float sparser = spacings[i] * static_cast<float>(kCellSpacings / cell) / kSparse;
    reaches[i] = std::clamp(kReach * sparser, kReach, kMostReach);
  }
  UncutMesh uncut = TRY(extract_surface({cloud, grid, reaches}, options.max_memory, executor));
  TriangleMesh& mesh = uncut.mesh;
  cut_border(mesh, uncut.beside);
  remove_folds(mesh);
  keep_manifold(mesh);
  close_holes(mesh, kMostHoleEdges);
  remove_specks(mesh, kLeastTriangles);
  remove_unused_vertices(mesh);
  if (options.triangles) simplify(mesh, *options.triangles);
  order_for_drawing(mesh);
  return std::move(mesh);
}

}  // namespace pointreel
