#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "tests/bench/measure.h"
#include "tests/bench/suites.h"

namespace pointreel::bench {

/// The lossless geometry of voxelised clouds, in bits per voxel and in time: every entropy coding
/// of the octree compared with Draco at its strongest compression. The clouds are a dense figure,
/// and the files of the options on grids of 10 and 12 bits: the grid divides the bounding cube of
/// the cloud into 2^bits - 1 cells along each axis, coordinates are rounded to the nearest cell,
/// and duplicates are removed. Appends the bars of the dense figure and of those files that have
/// limits.
nlohmann::json run_grids(const SuiteOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
