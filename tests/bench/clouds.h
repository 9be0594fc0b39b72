#pragma once

#include <cstddef>

#include "pointreel/cloud.h"

namespace pointreel::bench {

/// n points like those of the scanner of Slomp et al., Geometry Instancing, section III: they lie
/// on the curves that a projected grid draws on a bumpy closed surface about 1.8 high, dense along
/// a curve and sparse across, with noise, normals and colours. The same n gives the same cloud.
PointCloud scan_like_cloud(std::size_t n);

}  // namespace pointreel::bench
