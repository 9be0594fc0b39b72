#include "datasets_synthetic/sequences.h"

#include <array>
#include <cmath>
#include <string_view>

#include "codec/surface/normals.h"
#include "common/base/try.h"
#include "datasets_synthetic/random.h"
#include "datasets_synthetic/samplers/uniform.h"

namespace pointreel {
namespace {

/// The scanner's default settings for a motion. Spacing, pixel and calibration were fitted, with
/// seed 1 and over all poses, to the sequence of that name in Slomp et al., Geometry Instancing: to
/// its average number of points (Table I; met within 0.5 %), and to the leaves and inner nodes of
/// its octrees for delta = 2, 10 and 50 % with one cube per pose (Table III; within 10 %, at the
/// same depths 11, 10 and 9). A worse calibration keeps the curves of several pairs from sharing
/// cells: kick has the best calibration, because its clouds merge the most.
struct ScanSetting {
  std::string_view motion;
  std::size_t points;                              ///< per pose, on average
  double curve_spacing, pixel, calibration_shift;  ///< metres
  double depth_points;  ///< that the default depth cameras measure, per pose on average
};
constexpr std::array<ScanSetting, 6> kScanSettings = {{
    {"walk", 90000, 0.0190, 0.00253, 0.0012, 58900},
    {"baseball", 88315, 0.017511, 0.0026106, 0.00194, 58400},
    {"basketball", 87003, 0.022562, 0.0021204, 0.0018, 60450},
    {"kick", 101931, 0.015418, 0.0024563, 0.000448, 54500},
    {"soccer-juggle", 92352, 0.019235, 0.0023737, 0.00194, 61350},
    {"soccer-shoot", 60976, 0.026174, 0.0026474, 0.00097, 63700},
}};

const ScanSetting& scan_setting(const Motion& motion) {
  for (const ScanSetting& setting : kScanSettings) {
    if (setting.motion == motion.name) return setting;
  }
  return kScanSettings.front();
}

/// A point of the surface as it was measured.
struct Sample {
  glm::dvec3 position, normal;
  glm::u8vec3 color;
};

/// Points that lie exactly on the surface.
Result<std::vector<SurfacePoint>> exact_points(const Body& body, const SequenceOptions& options,
                                               std::size_t count, int number) {
  if (options.sampler == Sampler::uniform) {
    const std::uint64_t seed = Random(options.seed, 2 * static_cast<std::uint64_t>(number)).bits();
    return sample_uniform(body.surface, count, seed);
  }
  return sample_ldc(TRY(SurfaceGrid::build(body.surface)), options.ldc);
}

Result<std::vector<Sample>> sample(const Motion& motion, const Body& body,
                                   const SequenceOptions& options, int number) {
  const std::size_t count = points_per_frame(motion, options);
  std::vector<Sample> samples;
  if (options.sampler == Sampler::scan) {
    const auto points = TRY(scan(body, scan_options(motion, count), options.seed, number));
    samples.reserve(points.size());
    for (const ScanPoint& point : points) {
      samples.push_back({point.position, point.normal, point.color});
    }
    return samples;
  }
  if (options.sampler == Sampler::depth_cameras) {
    const auto points = TRY(capture_depth(
        body, depth_camera_options(motion, options.depth_cameras, count), options.seed, number));
    samples.reserve(points.size());
    for (const DepthPoint& point : points) {
      samples.push_back({point.position, point.normal, point.color});
    }
    return samples;
  }
  const auto points = TRY(exact_points(body, options, count, number));
  samples.reserve(points.size());
  for (const SurfacePoint& point : points) {
    samples.push_back(
        {point.position, point.normal, color_at(body, point.primitive, point.position)});
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

Pose frame_pose(const Motion& motion, const SequenceOptions& options, int number) {
  return motion.pose(options.still ? 0.0 : static_cast<double>(number) / options.fps);
}

std::size_t points_per_frame(const Motion& motion, const SequenceOptions& options) {
  return options.points > 0 ? options.points : scan_setting(motion).points;
}

ScanOptions scan_options(const Motion& motion, std::size_t points) {
  const ScanSetting& setting = scan_setting(motion);
  // Both spacings change together: dividing them by f gives f^2 times the points.
  const double finer = std::sqrt(static_cast<double>(points) / static_cast<double>(setting.points));
  ScanOptions options;
  options.curve_spacing = setting.curve_spacing / finer;
  options.pixel = setting.pixel / finer;
  options.calibration_shift = setting.calibration_shift;
  return options;
}

DepthCameraOptions depth_camera_options(const Motion& motion, DepthCameraOptions options,
                                        std::size_t points) {
  const double expected =
      scan_setting(motion).depth_points * options.cameras / DepthCameraOptions{}.cameras;
  options.pixel *= std::sqrt(expected / static_cast<double>(points));
  return options;
}

Result<PointCloud> sequence_frame(const Motion& motion, const SequenceOptions& options,
                                  int number) {
  const Body body = pose_body(frame_pose(motion, options, number));
  if (options.voxels) return voxelize(body, *options.voxels);
  const auto samples = TRY(sample(motion, body, options, number));
  const std::uint64_t noise_seed =
      Random(options.seed, 2 * static_cast<std::uint64_t>(number) + 1).bits();

  PointCloud cloud;
  cloud.positions.reserve(samples.size());
  cloud.colors.reserve(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& at = samples[i];
    glm::dvec3 position = at.position;
    if (options.noise > 0.0) {
      Random random(noise_seed, i);
      const double x = random.normal(), y = random.normal(), z = random.normal();
      position += options.noise * glm::dvec3(x, y, z);
    }
    cloud.positions.emplace_back(position);
    cloud.colors.push_back(glm::u16vec3(at.color) * std::uint16_t{257});
  }
  if (options.sampler == Sampler::scan) {
    estimate_normals_and_radii(cloud);
  } else {
    cloud.normals.reserve(samples.size());
    for (const Sample& at : samples) cloud.normals.emplace_back(at.normal);
  }
  return cloud;
}

}  // namespace pointreel
