#pragma once

#include <optional>
#include <string>

#include "pointreel/cloud.h"

namespace pointreel::bench {

/// The library that cleaning is compared with, and its version. Nothing if this program was built
/// without it.
std::optional<std::string> smoothing_library();

/// Moves the points and turns the normals by one pass of bilateral smoothing over the nearest 50
/// points (H. Huang et al., "Edge-Aware Point Set Resampling", 2013), on one thread. The cloud has
/// normals. Does nothing without the library.
void smooth_bilaterally(PointCloud& cloud);

}  // namespace pointreel::bench
