#include "codec/surface/clean.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "codec/core/keep_points.h"
#include "codec/core/lattice.h"
#include "codec/surface/normals.h"
#include "codec/surface/point_surface.h"
#include "common/base/median.h"
#include "pointreel/geometry.h"

namespace pointreel {
namespace {

/// Fewer points are no scan.
constexpr std::size_t kLeastPoints = 100;
/// Noise is the same thing whatever surface the points are moved to.
constexpr double kMeasuredBeta = CleanOptions{}.beta;
/// Around how many points noise and spacing are measured.
constexpr double kSupport = 50.0;
constexpr std::size_t kAveraged = 60;
constexpr std::uint32_t kMeasuredOneIn = 16;
/// Spacing is between these shares of what counting the points nearby tells, which is not exact:
/// noise and other sheets of the surface make the count larger, up to 2.4 in scans.
constexpr float kLeastLocalSpacing = 0.8f;
constexpr float kMostLocalSpacing = 2.5f;
constexpr int kMeasurements = 4;
/// Scans often consist of curves with gaps between them. Where the points around a place extend
/// less than this in some direction, compared with the radius, the radius grows: along a single
/// curve, the surface could turn around it freely.
constexpr float kLeastExtent = 0.035f;
constexpr float kMostWidening = 3.0f;
/// Above so many spacings of noise, points lie so far from the surface that it takes a second step
/// to look for it where it is.
constexpr double kNoisy = 0.25;
/// The radius of support is at least so many spacings, and at least so many times the root of
/// spacing times noise.
constexpr float kLeastSpacings = 3.0f;
constexpr float kNoiseFactor = 8.0f;
/// Colours become means within so many times the root of spacing times noise, unless that is less
/// than so many spacings: then the blending of edges costs as much as is gained.
constexpr float kColorNoiseFactor = 2.8f;
constexpr float kLeastColorSpacings = 1.25f;
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
/// The cells of a frame are at most so many times those that its densest parts need, and the
/// densest parts are this share of the points. Scans of one object have factors up to 1.6.
constexpr double kMostCoarsening = 2.0;
constexpr double kDensest = 0.01;

constexpr float kPi = 3.14159265f, kInfinity = std::numeric_limits<float>::infinity();

/// The weight that points `spacing` apart in a plane have together: the integral of (1 - x^2)^4
/// over the unit disc is pi / 5.
float weight_of_plane(float radius, float spacing) {
  const float ratio = radius / spacing;
  return kPi / 5.0f * ratio * ratio;
}

/// What was measured around each point.
struct Measured {
  float noise = 0.0f, spacing = 0.0f;
  float difference = 0.0f;  ///< the noise, by the steps between neighbours
  float widening = 1.0f;    ///< by which the radius must grow to reach points on all sides
};

float support(const Measured& at) {
  return at.widening *
         std::max(kLeastSpacings * at.spacing, kNoiseFactor * std::sqrt(at.noise * at.spacing));
}

std::vector<float> support(const std::vector<Measured>& measured) {
  std::vector<float> radii(measured.size());
  std::ranges::transform(measured, radii.begin(), [](const Measured& at) { return support(at); });
  return radii;
}

/// Finer cells would tell samples of the same spot apart: points are `spacing` apart, and details
/// much smaller than the support are gone.
float cell(const Measured& at) {
  return std::max(0.5f * at.spacing, std::sqrt(at.noise * at.spacing));
}

/// For the whole cloud.
double cell(const std::vector<Measured>& measured) {
  std::vector<float> cells(measured.size());
  std::ranges::transform(measured, cells.begin(), [](const Measured& at) { return cell(at); });
  const double middle = median(cells);
  const auto densest =
      cells.begin() + static_cast<std::ptrdiff_t>(kDensest * static_cast<double>(cells.size()));
  std::nth_element(cells.begin(), densest, cells.end());
  return std::min(middle, kMostCoarsening * *densest);
}

float median_of(const std::vector<Measured>& measured, float Measured::* member) {
  std::vector<float> values(measured.size());
  std::ranges::transform(measured, values.begin(), std::mem_fn(member));
  return median(values);
}

/// Noise is the distance to a surface that is fitted within a radius, which in turn depends on the
/// noise. A few rounds are enough, and so is a part of the points.
std::vector<Measured> measure(const PointSurface& surface, const Executor& executor) {
  std::vector<Measured> measured(surface.order().size());
  const std::vector<float> counted = surface.radii_of(kSupport);
  std::vector<float> radii = counted;
  for (int round = 0; round < kMeasurements; ++round) {
    const std::vector<SurfaceEvidence> evidence =
        surface.measure(radii, kMeasuredBeta, kMeasuredOneIn, executor);
    std::vector<glm::vec3> values(evidence.size());
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      const auto& [square, weight, extent, neighbor_square] = evidence[i];
      const float spacing = radii[i] * std::sqrt(kPi / (5.0f * weight));
      const float wider = std::sqrt(kLeastExtent / std::max(extent, kLeastExtent / 4.0f));
      const float widening =
          std::clamp(measured[i].widening * std::max(wider, 1.0f), 1.0f, kMostWidening);
      values[i] = weight > 0.0f
                      ? glm::vec3(square, round == 0 ? spacing : neighbor_square, widening)
                      : glm::vec3(-1.0f);
    }
    const std::vector<glm::vec3> means = surface.local_means(values, kAveraged);
    for (std::size_t i = 0; i < means.size(); ++i) {
      measured[i].noise = std::sqrt(means[i].x);
      if (round == 0) {
        // Means reach from small objects to those nearby.
        const float local = counted[i] * std::sqrt(kPi / static_cast<float>(kSupport));
        measured[i].spacing =
            std::clamp(means[i].y, kLeastLocalSpacing * local, kMostLocalSpacing * local);
      } else {
        measured[i].difference = std::sqrt(means[i].y);
        measured[i].widening = std::max(means[i].z, 1.0f);
      }
    }
    radii = support(measured);
  }
  return measured;
}

/// Sets the radii of points to 0 that lie in small clumps with gaps around them.
void leave_clumps(const PointSurface& surface, std::vector<float>& radii) {
  const std::vector<float> nearest = surface.radii_of(kNearest);
  const std::vector<float> counted = surface.radii_of(kSupport);
  for (std::size_t i = 0; i < radii.size(); ++i) {
    if (radii[i] > kMostReach * nearest[i] || counted[i] > kMostSupportReach * nearest[i])
      radii[i] = 0.0f;
  }
}

/// Replaces the colours by means along the surface, where that has a radius of support.
void mean_colors(PointCloud& cloud, const PointSurface& surface,
                 const std::vector<Measured>& measured, std::span<const float> supports,
                 const Executor& executor) {
  const std::span<const KeyIndex> order = surface.order();
  std::vector<float> radii(order.size());
  std::vector<glm::vec3> colors(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const float noise = measured[i].noise, spacing = measured[i].spacing;
    const float radius = kColorNoiseFactor * std::sqrt(noise * spacing);
    const bool averages = supports[i] > 0.0f && radius >= kLeastColorSpacings * spacing;
    radii[i] = averages ? radius : 0.0f;
    colors[i] = cloud.colors[order[i].index];
  }
  // More bits than the source has would only be noise to code.
  const float step = colors_fit_8_bits(cloud) ? 257.0f : 1.0f;
  colors = surface.weighted_means(radii, colors, executor);
  for (std::size_t i = 0; i < order.size(); ++i)
    cloud.colors[order[i].index] = glm::u16vec3(step * glm::floor(colors[i] / step + 0.5f));
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

bool is_voxelised(const PointCloud& cloud, double spacing) {
  const auto lattice = lattice_of(cloud);
  return lattice && spacing < kVoxelSpacing * lattice->step;
}

}  // namespace

CleanReport clean(PointCloud& cloud, const CleanOptions& options, const Executor& executor) {
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
  const int steps = report.noise > kNoisy * report.spacing ? 2 : 1;
  const std::vector<SurfaceSample> samples = surface.project(radii, options.beta, steps, executor);
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
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::uint32_t index = surface.order()[i].index;
    if (fates[index] != Fate::kMoved) continue;
    cloud.positions[index] = samples[i].position;
    cloud.normals[index] = samples[i].normal;
  }
  if (cloud.has_colors()) mean_colors(cloud, surface, measured, radii, executor);
  report.removed = keep_points(cloud, [&](std::size_t i) { return fates[i] != Fate::kRemoved; });
  report.cleaned = true;
  return report;
}

}  // namespace pointreel
