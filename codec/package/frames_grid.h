#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "codec/core/lattice.h"
#include "codec/package/encoding_options.h"
#include "codec/package/grid.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"

namespace pointreel {

/// What of a frame decides about the grid that it shares with others.
struct FrameExtent {
  Box box;
  std::optional<PointLattice> lattice;  ///< on which its points lie
  std::size_t points = 0;
  CleanReport cleaning;
};
FrameExtent extent_of(const PointCloud& cloud, const CleanReport& cleaning = {});

/// The grid that frames share. `cloud_of` gives the points of a frame; it is asked for no more than
/// one. Errors: as grid_for, and those of `cloud_of`.
Result<Grid> grid_for_frames(
    std::span<const FrameExtent> frames, const EncodingOptions& options,
    const std::function<Result<std::shared_ptr<const PointCloud>>(std::size_t)>& cloud_of);

}  // namespace pointreel
