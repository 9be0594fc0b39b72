#include "client/prepare/point_spacing.h"

#include <cmath>
#include <cstddef>

namespace pointreel {
namespace {

/// A level with at least this many points to a cell has hardly any gaps, so its cells tell the area
/// of the surface.
constexpr double kPointsPerCell = 3.0;
/// Cells that a surface passes through, for each square of a cell's edge that it measures: the mean
/// over all directions is 1.5.
constexpr double kCellsPerSquare = 1.5;

}  // namespace

float point_spacing(std::span<const std::uint32_t> occupied, double edge, std::uint64_t points) {
  if (points < 2) return 0.0f;
  double cell = edge, area = 0.0;
  for (const std::uint32_t cells : occupied) {
    if (kPointsPerCell * cells > static_cast<double>(points)) break;
    area = cells * cell * cell / kCellsPerSquare;
    cell *= 0.5;
  }
  return static_cast<float>(std::sqrt(area / static_cast<double>(points)));
}

}  // namespace pointreel
