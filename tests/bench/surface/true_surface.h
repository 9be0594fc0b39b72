#pragma once

#include "datasets_synthetic/body.h"
#include "pointreel/cloud.h"

namespace pointreel::bench {

/// Puts each point onto a near place of the true surface, with its normal and colour. Colours only
/// if the cloud has some.
PointCloud onto_true_surface(const Body& truth, const PointCloud& cloud);

/// How far a surface moves between two frames of a still scene, in metres: the root mean square
/// difference of the heights of surfels above the true surface, between each surfel of `before` and
/// the one of `after` that stands nearest to it on the true surface.
double movement_of_surface(const Body& truth, const PointCloud& before, const PointCloud& after);

}  // namespace pointreel::bench
