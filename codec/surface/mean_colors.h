#pragma once

#include <span>
#include <vector>

#include "codec/surface/point_surface.h"
#include "codec/surface/support.h"
#include "pointreel/cloud.h"
#include "pointreel/executor.h"

namespace pointreel {

/// Replaces the colours of noisy points by means along the surface. `surface`: of the cloud;
/// `measured` and `supports` are in its order. Points without a radius of support keep their
/// colours. `normals`: as PointSurface::weighted_means takes them.
void mean_colors(PointCloud& cloud, const PointSurface& surface,
                 const std::vector<Measured>& measured, std::span<const float> supports,
                 const Executor& executor, std::span<const glm::vec3> normals = {});

}  // namespace pointreel
