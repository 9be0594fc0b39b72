#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "tests/bench/measure.h"
#include "tests/bench/suites.h"

namespace pointreel::bench {

/// Geometry of voxelised clouds, without loss: every entropy coding of the octree against Draco at
/// its smallest, in bits a voxel and in time. A dense figure, and the files of the options on grids
/// of 10 and 12 bits: the grid divides the cloud's bounding cube into
/// 2^bits - 1 cells a side, coordinates are rounded to the nearest, duplicates removed. Appends the
/// bars of the dense figure and of files that have some.
nlohmann::json run_grids(const SuiteOptions& options, std::vector<Bar>& bars);

}  // namespace pointreel::bench
