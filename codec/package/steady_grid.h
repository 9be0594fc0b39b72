#pragma once

#include <optional>

#include "codec/core/lattice.h"
#include "codec/package/encoding_options.h"
#include "codec/package/grid.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"

namespace pointreel {

/// A cube that consecutive frames share, so that voxels do not jump between them. It stays until a
/// frame does not fit. Then it gets a margin of a tenth of the frame's box on each side, and still
/// holds what the previous cube was made for, unless that would make it more than twice as large. A
/// cube eight times as large as a frame is made anew.
/// Voxelised frames are coded on their own lattice, as pack does, so that they come back exactly or
/// without a shift, and the cells of cleaned frames are those that fit their points, until these
/// change by a quarter.
class SteadyGrid {
 public:
  explicit SteadyGrid(const EncodingOptions& options) : options_(options) {}
  /// The grid to encode a cloud in, whose points lie within `box`.
  Result<Grid> of(const PointCloud& cloud, const Box& box, const CleanReport& cleaning = {});

 private:
  EncodingOptions options_;
  std::optional<Grid> grid_;
  Box held_;                             ///< what the grid was made for
  std::optional<PointLattice> lattice_;  ///< of the frames that it was made for
  bool on_lattice_ = false;              ///< the grid's cells are the lattice's
};

}  // namespace pointreel
