#include "codec/surface/clean.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "codec/core/keep_points.h"
#include "codec/core/lattice.h"
#include "codec/surface/mean_colors.h"
#include "codec/surface/normals.h"
#include "codec/surface/point_surface.h"
#include "codec/surface/support.h"
#include "common/base/median.h"
#include "pointreel/geometry.h"

namespace pointreel {
namespace {

/// Fewer points are no scan.
constexpr std::size_t kLeastPoints = 100;
/// Noise below this share of the spacing is not worth the detail that removing it costs.
constexpr double kSmooth = 0.1;
/// Voxels of a surface are at most so many steps of their lattice apart on average.
constexpr double kVoxelSpacing = 1.1;
/// In scans, nearest neighbours differ across the surface by at least 0.46 of what the noise of
/// both explains. Where they differ by less than this share, or the radius of support would be more
/// than so many spacings, what looks like noise is something else, such as the distance between the
/// rings of a lidar that sees rooms with corners.
constexpr double kLeastDifference = 0.3;
constexpr double kMostSpacings = 14.0;
/// Where most points have another one within this share of the spacing, they are repeated, as by
/// overlapping exports: neighbours no longer tell spacing and noise.
constexpr float kRepeated = 0.1f;
/// Points with less than this share of the weight that a surface would give them are alone.
constexpr float kLeastSupport = 0.2f;
/// What a point contributes itself is at most 1.
constexpr float kOwnSampleWeight = 1.01f;
/// A cloud of which a smaller share has a surface is no scan of one.
constexpr double kLeastKept = 0.5;
/// Where the radius would be more than so many times that of the nearest points, or that of
/// kSupport points is, the next ones lie beyond a gap, and a surface through all of them would
/// cross it. Scans with noise of 1 cm have ratios up to 11 and 3.3.
constexpr double kNearest = 12.0;
constexpr float kMostReach = 14.0f;
constexpr float kMostSupportReach = 4.0f;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Sets the radii of points to 0 that lie in small clumps with gaps around them.
void leave_clumps(const PointSurface& surface, std::vector<float>& radii) {
  const std::vector<float> nearest = surface.radii_of(kNearest);
  const std::vector<float> counted = surface.radii_of(kSupport);
  for (std::size_t i = 0; i < radii.size(); ++i) {
    if (radii[i] > kMostReach * nearest[i] || counted[i] > kMostSupportReach * nearest[i])
      radii[i] = 0.0f;
  }
}

/// Whether most points are repeated, perhaps not exactly. Repeated points lie side by side in
/// Morton order, except for a few at the borders of cells.
bool repeats_points(const PointCloud& cloud, const PointSurface& surface,
                    const std::vector<Measured>& measured) {
  const auto position = [&](std::size_t i) { return cloud.positions[surface.order()[i].index]; };
  std::size_t repeated = 0;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const glm::vec3 at = position(i);
    const float before = i > 0 ? glm::distance(at, position(i - 1)) : kInfinity;
    const float after = i + 1 < measured.size() ? glm::distance(at, position(i + 1)) : kInfinity;
    if (std::min(before, after) < kRepeated * measured[i].spacing) ++repeated;
  }
  return 2 * repeated > measured.size();
}

/// Whether squares of its extent and of the distances within it are floats of full precision.
bool has_usable_scale(const PointCloud& cloud) {
  const double edge = bounding_cube(bounds(cloud)).edge;
  return edge > 1e-12 && edge < 1e15;
}

/// Of the points that `keeps` keeps.
template <class Keeps>
BeforeCleaning before_of(const PointCloud& cloud, const PointSurface& surface,
                         const std::vector<Measured>& measured, const Keeps& keeps) {
  std::vector<Measured> of_points(measured.size());
  for (std::size_t i = 0; i < measured.size(); ++i)
    of_points[surface.order()[i].index] = measured[i];
  BeforeCleaning before;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!keeps(i)) continue;
    before.positions.push_back(cloud.positions[i]);
    if (cloud.has_colors()) before.colors.push_back(cloud.colors[i]);
    before.measured.push_back(of_points[i]);
  }
  return before;
}

bool is_voxelised(const PointCloud& cloud, double spacing) {
  const auto lattice = lattice_of(cloud);
  return lattice && spacing < kVoxelSpacing * lattice->step;
}

}  // namespace

CleanReport clean(PointCloud& cloud, const CleanOptions& options, const Executor& executor,
                  BeforeCleaning* before) {
  CleanReport report;
  if (cloud.size() < kLeastPoints || !has_usable_scale(cloud)) return report;
  if (!cloud.has_normals() && !options.without_normals) return report;
  const std::vector<glm::vec3> given_normals = cloud.normals;
  complete_normals(cloud, executor);
  PointSurface surface(cloud, executor);
  const std::vector<Measured> measured = measure(surface, executor);
  report.spacing = median_of(measured, &Measured::spacing);
  report.noise = median_of(measured, &Measured::noise);
  std::vector<float> radii =
      options.radius ? std::vector<float>(cloud.size(), static_cast<float>(*options.radius))
                     : support(measured);
  report.radius = median(radii);
  const bool is_noise =
      report.noise > kSmooth * report.spacing &&
      median_of(measured, &Measured::difference) >= kLeastDifference * report.noise &&
      report.radius <= kMostSpacings * report.spacing;
  if (!options.radius && (!is_noise || is_voxelised(cloud, report.spacing) ||
                          repeats_points(cloud, surface, measured))) {
    cloud.normals = given_normals;
    report.radius = 0.0;
    return report;
  }
  report.cell = cell(measured);
  if (!options.radius) leave_clumps(surface, radii);
  surface.fit_normals(radii, executor);
  const std::vector<SurfaceSample> samples = surface.project(
      radii, options.beta, steps_to_surface(report.noise, report.spacing), executor);
  enum class Fate : std::uint8_t { kRemoved, kUnchanged, kMoved };
  std::vector<Fate> fates(cloud.size());
  std::size_t moved = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::uint32_t index = surface.order()[i].index;
    const float whole = weight_of_plane(radii[i], measured[i].spacing);
    if (radii[i] == 0.0f) {
      fates[index] = Fate::kUnchanged;
    } else if (!(samples[i].weight > std::max(kLeastSupport * whole, kOwnSampleWeight))) {
      fates[index] = Fate::kRemoved;
    } else if (glm::distance(samples[i].position, cloud.positions[index]) > report.radius) {
      fates[index] = Fate::kUnchanged;
    } else {
      fates[index] = Fate::kMoved;
      ++moved;
    }
  }
  if (static_cast<double>(moved) < kLeastKept * static_cast<double>(cloud.size())) {
    cloud.normals = given_normals;
    return report;
  }
  const auto keeps = [&](std::size_t i) { return fates[i] != Fate::kRemoved; };
  if (before != nullptr) *before = before_of(cloud, surface, measured, keeps);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::uint32_t index = surface.order()[i].index;
    if (fates[index] != Fate::kMoved) continue;
    cloud.positions[index] = samples[i].position;
    cloud.normals[index] = samples[i].normal;
  }
  if (cloud.has_colors()) mean_colors(cloud, surface, measured, radii, executor);
  report.removed = keep_points(cloud, keeps);
  report.cleaned = true;
  return report;
}

}  // namespace pointreel
