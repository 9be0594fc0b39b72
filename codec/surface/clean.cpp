#include "codec/surface/clean.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "codec/core/build.h"
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
/// Frames of a sequence that is worth cleaning, or is not, may have so many times less noise, or
/// more.
constexpr double kLikeOthers = 1.5;
/// Voxels of a surface are at most so many steps of their lattice apart on average.
constexpr double kVoxelSpacing = 1.1;
/// A surface passes through 16 times as many voxels as cells that are four times as large. Where
/// points have so many of these, they are no farther apart than that, and it need not be measured.
constexpr double kFilled = 11.0;
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

/// The least noise that is removed, as a share of the spacing.
double smooth(const CleanOptions& options) {
  if (!options.noisy) return kSmooth;
  return *options.noisy ? kSmooth / kLikeOthers : kSmooth * kLikeOthers;
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

/// Whether the points are almost all of the voxels that their surface passes through.
bool fills_voxels(const PointCloud& cloud, const PointLattice& lattice, const Executor& executor) {
  const VoxelCube voxels = lattice_cube(bounds(cloud), lattice);
  if (voxels.depth < 2 || voxels.depth > kMaxDepth) return false;
  const SortedPoints sorted = sort_points(cloud, voxels.cube, voxels.depth, executor);
  const auto depth = static_cast<std::size_t>(voxels.depth);
  return sorted.occupied[depth] >= kFilled * sorted.occupied[depth - 2];
}

}  // namespace

CleanReport clean(PointCloud& cloud, const CleanOptions& options, const Executor& executor,
                  BeforeCleaning* before) {
  CleanReport report;
  const auto stays = [&report](NotCleaned why) {
    report.why = why;
    return report;
  };
  if (cloud.size() < kLeastPoints) return stays(NotCleaned::few_points);
  if (!has_usable_scale(cloud)) return stays(NotCleaned::no_surface);
  if (!cloud.has_normals() && !options.without_normals) return stays(NotCleaned::no_normals);
  const auto lattice = options.radius ? std::nullopt : lattice_of(cloud);
  if (lattice && fills_voxels(cloud, *lattice, executor)) return stays(NotCleaned::voxelised);
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
  const auto why_not = [&]() -> std::optional<NotCleaned> {
    if (options.radius) return std::nullopt;
    if (lattice && report.spacing < kVoxelSpacing * lattice->step) return NotCleaned::voxelised;
    if (!(report.noise > smooth(options) * report.spacing)) return NotCleaned::smooth;
    if (!(median_of(measured, &Measured::difference) >= kLeastDifference * report.noise) ||
        !(report.radius <= kMostSpacings * report.spacing))
      return NotCleaned::no_surface;
    if (repeats_points(cloud, surface, measured)) return NotCleaned::repeated;
    return std::nullopt;
  }();
  if (why_not) {
    cloud.normals = given_normals;
    report.radius = 0.0;
    return stays(*why_not);
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
    return stays(NotCleaned::no_surface);
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
