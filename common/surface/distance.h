#pragma once

#include "common/base/error.h"
#include "common/cloud/point_cloud.h"

namespace pointreel {

/// Distances from the points of one cloud to their nearest neighbours in another.
struct OneWayDistance {
  double mean_squared = 0.0;
  double max = 0.0;
};

/// The geometry error between two clouds, in the units of their coordinates (D1 of MPEG's
/// pc_error). D1 in the symmetric sense is the larger of the two mean squares.
struct CloudDistance {
  OneWayDistance a_to_b;
  OneWayDistance b_to_a;

  double d1() const;   ///< squared units
  double max() const;  ///< the largest distance of all (symmetric Hausdorff)
};

/// Peak signal-to-noise ratio in dB, 10 log10(3 peak^2 / d1): `peak` is the largest coordinate of
/// the source's grid, 2^bits - 1, in the units of the clouds. Infinite where d1 is 0.
double d1_psnr(double d1, double peak);

/// Compares two clouds in world coordinates, each relative to a common origin in double, with an
/// exact nearest-neighbour search (k-d tree); O((n + m) log(n + m)) and not meant for playback. An
/// error if either cloud is empty; positions are finite.
Result<CloudDistance> cloud_distance(const PointCloud& a, const PointCloud& b);

}  // namespace pointreel
