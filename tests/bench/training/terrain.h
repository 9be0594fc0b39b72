#pragma once

#include <cstddef>

#include "datasets_synthetic/random.h"
#include "tests/bench/training/sampled_surface.h"

/// Landscapes as aircraft see them, to train on.
namespace pointreel::bench {

/// Ground as an aircraft sees it, with one height at each place.
SampledSurface terrain(std::size_t count, Random& random);

/// Arranges points in lines like those of an airborne scanner: close within a line and further
/// apart from line to line, with some returns from vegetation above the ground.
SampledSurface flown_over(const SampledSurface& ground, double line, double vegetation,
                          Random& random);

/// Puts flat roofs and walls on a tenth of the ground and rotates everything, because no flight
/// follows the grid.
SampledSurface built_up(SampledSurface ground, Random& random);

}  // namespace pointreel::bench
