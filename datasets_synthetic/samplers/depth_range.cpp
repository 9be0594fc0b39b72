#include "datasets_synthetic/samplers/depth_range.h"

#include <algorithm>
#include <cmath>

namespace pointreel {

DepthRange::DepthRange(const SurfaceGrid& grid, const Pinhole& view, double half_field)
    : half_field_(half_field), tiles_per_unit_(200.0) {
  tiles_ = static_cast<int>(2.0 * half_field * tiles_per_unit_) + 1;
  ranges_.resize(static_cast<std::size_t>(tiles_) * static_cast<std::size_t>(tiles_));
  const double reach = 0.5 * std::sqrt(3.0) * SurfaceGrid::kCell;
  for (const SurfaceGrid::Cell& cell : grid.cells()) {
    if (std::abs(cell.distance) > reach) continue;  // the surface is near, but not in this cell
    const glm::dvec3 center = cell.min + 0.5 * SurfaceGrid::kCell;
    const glm::dvec3 at = view.project(center);
    if (at.z <= 2.0 * reach) continue;
    const glm::dvec3 d = center - view.position;
    const double distance = std::sqrt(glm::dot(d, d));
    const auto near = static_cast<float>(distance - reach - 1e-6);
    const auto far = static_cast<float>(distance + reach + 1e-6);
    // Away from the middle of the picture the ball around the cell appears wider in the picture
    // plane, at most by the square of this factor.
    const double slant = distance / at.z;
    const double spread = reach / (at.z - reach) * slant * slant;
    const int x0 = std::max(tile_of(at.x - spread), 0), y0 = std::max(tile_of(at.y - spread), 0);
    const int x1 = std::min(tile_of(at.x + spread), tiles_ - 1);
    const int y1 = std::min(tile_of(at.y + spread), tiles_ - 1);
    for (int y = y0; y <= y1; ++y) {
      Range* row = ranges_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(tiles_);
      for (int x = x0; x <= x1; ++x) {
        if (row[x].empty()) {
          row[x] = {near, far};
        } else {
          row[x].near = std::min(row[x].near, near);
          row[x].far = std::max(row[x].far, far);
        }
      }
    }
  }
}

}  // namespace pointreel
