#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "datasets_synthetic/samplers/pinhole.h"
#include "datasets_synthetic/surface_grid.h"

namespace pointreel {

/// The range of distances at which a pinhole may see the surface, for every tile of its picture.
/// Rays need to search only this range. It is derived from the cells of a grid and never too small.
class DepthRange {
 public:
  struct Range {
    float near = 0.0f, far = -1.0f;  ///< metres from the pinhole; far < near if there is no surface

    bool empty() const { return far < near; }
  };

  /// The picture is the square |x|, |y| <= half_field.
  DepthRange(const SurfaceGrid& grid, const Pinhole& view, double half_field);

  int tiles() const { return tiles_; }  ///< along each side of the picture
  int tile_of(double x) const { return static_cast<int>((x + half_field_) * tiles_per_unit_); }
  double tile_begin(int tile) const { return tile / tiles_per_unit_ - half_field_; }
  const Range& at(int x, int y) const {
    return ranges_[static_cast<std::size_t>(y) * static_cast<std::size_t>(tiles_) +
                   static_cast<std::size_t>(x)];
  }

 private:
  double half_field_, tiles_per_unit_;
  int tiles_;
  std::vector<Range> ranges_;
};

}  // namespace pointreel
