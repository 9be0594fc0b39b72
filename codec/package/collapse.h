#pragma once

#include <optional>
#include <string>

#include "codec/package/grid.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"

namespace pointreel {

struct Collapse {
  std::string what;        ///< "its 400 points collapse into voxels of 0.477"
  std::string why;         ///< "the frames of its segment lie too far apart for one cube"
  bool far_apart = false;  ///< they do, and it is not that points of the frame are too far away
};

/// Why a frame that was encoded in this grid would be far coarser than was asked for: because its
/// cube is too large for its points. That is so if the frame has fewer than half the voxels that a
/// delta promises and the middle half of its points is less than 16 voxels long; or, with a fixed
/// depth, if it lies in a cube more than 16 times as large as its own, and is itself less than 16
/// voxels long. Nothing if the frame is as it should be, or if its depth was lowered on request.
///
/// `cloud` is the source of `encoded`, `used` the options it was encoded with. `strays`: some
/// points lie far from all others; then the frame is as large as these others.
std::optional<Collapse> collapse_of(const EncodedFrame& encoded, const PointCloud& cloud,
                                    const Grid& grid, const EncodeOptions& used, bool strays);

/// The same as an error (`limit`), for frames that were encoded as their grid says. It does not
/// tell the cause if that is `strays` (blame() in strays.h).
Result<void> check_collapse(const EncodedFrame& encoded, const PointCloud& cloud, const Grid& grid,
                            bool strays);

}  // namespace pointreel
