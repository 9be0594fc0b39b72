#pragma once

#include <cstddef>

#include "datasets_synthetic/random.h"
#include "pointreel/error.h"
#include "tests/bench/training/sampled_surface.h"

/// People, to train on.
namespace pointreel::bench {

/// A figure of the synthetic sequences in a random pose. Its samples are in random order.
Result<SampledSurface> figure(std::size_t count, Random& random);

/// A figure with few flat faces, like a low-poly model: prisms along the bones of a body.
SampledSurface faceted_figure(std::size_t count, Random& random);

}  // namespace pointreel::bench
