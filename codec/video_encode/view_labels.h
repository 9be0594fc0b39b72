#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "codec/video_encode/surface_points.h"

namespace pointreel {

/// Chooses for each point the view that it belongs to: one that it faces and that its neighbours
/// belong to, and, where the surface has not moved, the one of the frame before. Patches that are
/// large and stay the same are what makes the video cheap.
class ViewLabels {
 public:
  /// Of the next frame of a group.
  std::vector<std::uint8_t> next(const SurfacePoints& points);

 private:
  /// What a cell of a few pixels holds of a frame.
  struct Cell {
    std::array<float, kViews> labels{};  ///< points of each view, in the cell and those around it
    glm::vec3 mean{0.0f};                ///< of the places
  };

  std::unordered_map<std::uint32_t, Cell> before_;
};

}  // namespace pointreel
