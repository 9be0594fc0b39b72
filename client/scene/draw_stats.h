#pragma once

#include <cstdint>

namespace pointreel {

/// How much coarser than asked a picture is drawn because time is short.
struct DraftCoarsening {
  int reduction = 1;        ///< DrawOptions::reduction
  float pixel_size = 1.0f;  ///< DrawOptions::pixel_size is this many times as large

  bool operator==(const DraftCoarsening&) const = default;
};

/// What drawing a picture took, and what was left out of it.
struct DrawStats {
  std::uint32_t drawn = 0;    ///< surfels, points, voxels or triangles submitted
  std::uint32_t visited = 0;  ///< octree nodes that the cut visited
  /// Leaves of the octree that the cut left out: because they are outside the frustum, or because a
  /// node above them is smaller than a pixel and is drawn in place of all its leaves (one leaf per
  /// such node does not count). With strips, these are triangles.
  std::uint32_t out_of_view = 0, below_pixel = 0;
  /// Voxels left out because their neighbours hide them, or triangles that face away.
  std::uint32_t hidden = 0;
  DraftCoarsening coarsening;
  double cut_ms = 0.0;  ///< the cut of the octree; 0 if the last cut was used again
  /// Wall time of packing, upload and drawing, until the picture is complete. Does not include the
  /// cut.
  double render_ms = 0.0;
};

}  // namespace pointreel
