#include "common/surface/clean.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/base/median.h"
#include "common/cloud/keep_points.h"
#include "common/cloud/lattice.h"
#include "common/surface/normals.h"
#include "common/surface/point_surface.h"

namespace pointreel {
namespace {

/// Fewer points are no scan.
constexpr std::size_t kLeastPoints = 100;
/// A little less curvature than the best sphere has: noisy normals make spheres too small.
constexpr double kBeta = 0.5;
/// Around how many points noise and spacing are measured.
constexpr double kSupport = 50.0;
constexpr std::size_t kAveraged = 60;
constexpr std::size_t kMeasuredOneIn = 4;
constexpr int kMeasurements = 3;
constexpr int kSteps = 2;
/// The radius of support is at least so many spacings, and at least so many times the root of
/// spacing times noise.
constexpr float kLeastSpacings = 3.0f;
constexpr float kNoiseFactor = 8.0f;
/// Noise below this share of the spacing is not worth the detail that removing it costs.
constexpr double kSmooth = 0.1;
/// Voxels of a surface are at most so many steps of their lattice apart on average.
constexpr double kVoxelSpacing = 1.1;
/// Points with less than this share of the weight that a surface would give them are alone.
constexpr float kLeastSupport = 0.2f;

constexpr float kPi = 3.14159265f;

/// The weight that points `spacing` apart in a plane have together: the integral of (1 - x^2)^4
/// over the unit disc is pi / 5.
float weight_of_plane(float radius, float spacing) {
  const float ratio = radius / spacing;
  return kPi / 5.0f * ratio * ratio;
}

/// Noise and spacing around each point.
struct Measured {
  std::vector<float> noise, spacing;
};

std::vector<float> support(const Measured& measured) {
  std::vector<float> radii(measured.noise.size());
  for (std::size_t i = 0; i < radii.size(); ++i) {
    const float spacing = measured.spacing[i];
    radii[i] =
        std::max(kLeastSpacings * spacing, kNoiseFactor * std::sqrt(measured.noise[i] * spacing));
  }
  return radii;
}

/// Noise is the distance to a surface that is fitted within a radius, which in turn depends on the
/// noise. Three rounds are enough, and so is a part of the points.
Measured measure(const PointSurface& surface, const PointCloud& cloud, const Executor& executor) {
  Measured measured;
  std::vector<float> radii = surface.radii_of(kSupport);
  const auto leave_most_out = [&] {
    for (std::size_t i = 0; i < radii.size(); ++i) {
      if (i % kMeasuredOneIn != 0) radii[i] = 0.0f;
    }
  };
  leave_most_out();
  for (int round = 0; round < kMeasurements; ++round) {
    const std::vector<SurfaceSample> samples = surface.project(radii, kBeta, 1, executor);
    std::vector<float> squares(samples.size()), spacings(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const glm::vec3 step = samples[i].position - cloud.positions[surface.order()[i].index];
      const bool known = samples[i].weight > 0.0f;
      squares[i] = known ? glm::dot(step, step) : -1.0f;
      spacings[i] = known ? radii[i] * std::sqrt(kPi / (5.0f * samples[i].weight)) : -1.0f;
    }
    measured.noise = surface.local_mean(squares, kAveraged);
    for (float& noise : measured.noise) noise = std::sqrt(noise);
    if (round == 0) measured.spacing = surface.local_mean(spacings, kAveraged);
    radii = support(measured);
    leave_most_out();
  }
  return measured;
}

bool is_voxelised(const PointCloud& cloud, double spacing) {
  const auto lattice = lattice_of(cloud);
  return lattice && spacing < kVoxelSpacing * lattice->step;
}

}  // namespace

CleanReport clean(PointCloud& cloud, const CleanOptions& options, const Executor& executor) {
  CleanReport report;
  if (cloud.size() < kLeastPoints) return report;
  const bool had_normals = cloud.has_normals();
  if (!had_normals) estimate_normals(cloud);
  const PointSurface surface(cloud);
  const Measured measured = measure(surface, cloud, executor);
  report.spacing = median(measured.spacing);
  report.noise = median(measured.noise);
  if (!options.radius &&
      (report.noise < kSmooth * report.spacing || is_voxelised(cloud, report.spacing))) {
    if (!had_normals) cloud.normals.clear();
    return report;
  }

  std::vector<float> radii =
      options.radius ? std::vector<float>(cloud.size(), static_cast<float>(*options.radius))
                     : support(measured);
  report.radius = median(radii);
  const std::vector<SurfaceSample> samples = surface.project(radii, kBeta, kSteps, executor);
  std::vector<std::uint8_t> kept(cloud.size(), 0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::uint32_t index = surface.order()[i].index;
    const SurfaceSample& sample = samples[i];
    const float whole = weight_of_plane(radii[i], measured.spacing[i]);
    if (!(sample.weight > kLeastSupport * whole)) continue;
    kept[index] = 1;
    cloud.positions[index] = sample.position;
    cloud.normals[index] = sample.normal;
  }
  report.removed = keep_points(cloud, [&](std::size_t i) { return kept[i] != 0; });
  report.cleaned = true;
  return report;
}

}  // namespace pointreel
