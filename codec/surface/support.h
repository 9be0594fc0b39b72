#pragma once

#include <vector>

#include "codec/surface/point_surface.h"
#include "pointreel/executor.h"

namespace pointreel {

/// Around how many points noise and spacing are measured.
inline constexpr double kSupport = 50.0;

/// What was measured around a point, in the units of the cloud.
struct Measured {
  float noise = 0.0f, spacing = 0.0f;
  float difference = 0.0f;  ///< the noise, by the steps between neighbours
  float widening = 1.0f;    ///< by which the radius must grow to reach points on all sides
};

/// For each point, in the order of the surface (common/FORMULAS.md, "Noise and support").
std::vector<Measured> measure(const PointSurface& surface, const Executor& executor);
/// The radius of support of each point.
std::vector<float> support(const std::vector<Measured>& measured);
/// Of cells, for the whole cloud: CleanReport::cell.
double cell(const std::vector<Measured>& measured);
/// How often points are projected to reach the surface.
int steps_to_surface(double noise, double spacing);
/// The weight that points `spacing` apart in a plane have together: the integral of (1 - x^2)^4
/// over the unit disc is pi / 5.
float weight_of_plane(float radius, float spacing);
float median_of(const std::vector<Measured>& measured, float Measured::* member);

}  // namespace pointreel
