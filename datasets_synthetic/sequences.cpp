#include "datasets_synthetic/sequences.h"

#include <array>
#include <cmath>
#include <string_view>

#include "common/surface/normals.h"
#include "datasets_synthetic/random.h"
#include "datasets_synthetic/samplers/uniform.h"

namespace pointreel {
namespace {

/// What a motion is scanned with by default.
struct ScanSetting {
  std::string_view motion;
  std::size_t points;    ///< a pose on average: paper 2, Table I
  double curve_spacing;  ///< metres
  double pixel;          ///< metres
};
constexpr std::array<ScanSetting, 1> kScanSettings = {{
    {"walk", 90000, 0.01825, 0.00253},
}};

const ScanSetting& scan_setting(const Motion& motion) {
  for (const ScanSetting& setting : kScanSettings) {
    if (setting.motion == motion.name) return setting;
  }
  return kScanSettings.front();
}

/// A point of the surface and where it was found to be.
struct Sample {
  glm::dvec3 position, truth, normal;
  std::uint16_t primitive;
};

/// Points of the surface itself.
Result<std::vector<SurfacePoint>> exact_points(const Body& body, const SequenceOptions& options,
                                               std::size_t count, int number) {
  if (options.sampler == Sampler::uniform) {
    const std::uint64_t seed = Random(options.seed, 2 * static_cast<std::uint64_t>(number)).bits();
    return sample_uniform(body.surface, count, seed);
  }
  const auto grid = SurfaceGrid::build(body.surface);
  if (!grid) return tl::unexpected(grid.error());
  return sample_ldc(*grid, options.ldc);
}

Result<std::vector<Sample>> sample(const Motion& motion, const Body& body,
                                   const SequenceOptions& options, int number) {
  const std::size_t count = points_per_frame(motion, options);
  std::vector<Sample> samples;
  if (options.sampler == Sampler::scan) {
    const auto points = scan(body, scan_options(motion, count), options.seed, number);
    if (!points) return tl::unexpected(points.error());
    samples.reserve(points->size());
    for (const ScanPoint& point : *points) {
      samples.push_back({point.position, point.truth, point.normal, point.primitive});
    }
    return samples;
  }
  const auto points = exact_points(body, options, count, number);
  if (!points) return tl::unexpected(points.error());
  samples.reserve(points->size());
  for (const SurfacePoint& point : *points) {
    samples.push_back({point.position, point.position, point.normal, point.primitive});
  }
  return samples;
}

}  // namespace

Box sequence_bounds(const Motion& motion, double fps, int frames) {
  Box box;
  for (int i = 0; i < frames; ++i) {
    box.grow(bounds(pose_body(motion.pose(static_cast<double>(i) / fps)).surface));
  }
  return box;
}

std::size_t points_per_frame(const Motion& motion, const SequenceOptions& options) {
  return options.points > 0 ? options.points : scan_setting(motion).points;
}

ScanOptions scan_options(const Motion& motion, std::size_t points) {
  const ScanSetting& setting = scan_setting(motion);
  // Both spacings change together: f times as fine gives f^2 times the points, if no curve lost a
  // pixel or two at its ends. With those it is (1 + kEnds) f^2 - kEnds f times, as was measured for
  // 1/15 to 4 times the points.
  constexpr double kEnds = 0.046;
  const double more = static_cast<double>(points) / static_cast<double>(setting.points);
  const double finer =
      (kEnds + std::sqrt(kEnds * kEnds + 4.0 * (1.0 + kEnds) * more)) / (2.0 * (1.0 + kEnds));
  ScanOptions options;
  options.curve_spacing = setting.curve_spacing / finer;
  options.pixel = setting.pixel / finer;
  return options;
}

Result<PointCloud> sequence_frame(const Motion& motion, const SequenceOptions& options,
                                  int number) {
  const Body body = pose_body(motion.pose(static_cast<double>(number) / options.fps));
  if (options.voxels) return voxelize(body, *options.voxels);
  const auto samples = sample(motion, body, options, number);
  if (!samples) return tl::unexpected(samples.error());
  const std::uint64_t noise_seed =
      Random(options.seed, 2 * static_cast<std::uint64_t>(number) + 1).bits();

  PointCloud cloud;
  cloud.positions.reserve(samples->size());
  cloud.colors.reserve(samples->size());
  for (std::size_t i = 0; i < samples->size(); ++i) {
    const Sample& at = (*samples)[i];
    glm::dvec3 position = at.position;
    if (options.noise > 0.0) {
      Random random(noise_seed, i);
      const double x = random.normal(), y = random.normal(), z = random.normal();
      position += options.noise * glm::dvec3(x, y, z);
    }
    cloud.positions.emplace_back(position);
    cloud.colors.push_back(glm::u16vec3(color_at(body, at.primitive, at.truth)) *
                           std::uint16_t{257});
  }
  if (options.sampler == Sampler::scan) {
    estimate_normals_and_radii(cloud);
  } else {
    cloud.normals.reserve(samples->size());
    for (const Sample& at : *samples) cloud.normals.emplace_back(at.normal);
  }
  return cloud;
}

}  // namespace pointreel
