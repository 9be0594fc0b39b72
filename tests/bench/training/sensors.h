#pragma once

#include <cstddef>

#include "datasets_synthetic/random.h"
#include "tests/bench/training/sampled_surface.h"

/// Which samples of a surface sensors and tools keep, and with what errors.
namespace pointreel::bench {

/// Replaces each sample by five, which lie a little apart on the surface, so that no voxel on it
/// stays empty.
SampledSurface filled(const SampledSurface& surface, double spacing);

/// The first `count` samples; all if there are fewer.
SampledSurface first(const SampledSurface& surface, std::size_t count);

/// Keeps samples like the vertices of a scanned mesh: no two are closer than a distance that varies
/// slowly over the surface (dart throwing: Cook, "Stochastic sampling in computer graphics", 1986).
SampledSurface spaced(const SampledSurface& surface, double distance, double variation,
                      Random& random);

/// The errors of depth cameras: each camera is shifted and distorted, measures depth in steps, and
/// places "flying" points between near and far objects at their edges.
struct CameraErrors {
  double shift = 0.0, bend = 0.0, step = 0.0, flying = 0.0;
};

/// The points that cameras around the surface see: the nearest one in each of their pixels.
SampledSurface scanned(const SampledSurface& surface, int cameras, double pixel, Random& random,
                       const CameraErrors& errors = {});

/// Adds errors along the normal (for scanned surfaces: along the line of sight), occasionally
/// larger ones, and outliers.
void disturb(SampledSurface& surface, double noise, double outliers, Random& random);

}  // namespace pointreel::bench
