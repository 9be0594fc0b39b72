#pragma once

#include <cstddef>

#include "pointreel/cloud.h"

namespace pointreel::bench {

/// Points like those of the paper's scanner: along the curves that a projected grid draws on a
/// bumpy closed surface about 1.8 high, dense along a curve, sparse across, with noise. Has normals
/// and colours. The same for the same n.
PointCloud scan_like_cloud(std::size_t n);

}  // namespace pointreel::bench
