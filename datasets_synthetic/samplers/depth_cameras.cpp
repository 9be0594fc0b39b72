#include "datasets_synthetic/samplers/depth_cameras.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <tbb/parallel_for.h>

#include "common/base/try.h"
#include "datasets_synthetic/random.h"
#include "datasets_synthetic/ray_cast.h"
#include "datasets_synthetic/samplers/depth_image.h"
#include "datasets_synthetic/samplers/measurement_error.h"
#include "datasets_synthetic/trigonometry.h"
#include "datasets_synthetic/vectors.h"

namespace pointreel {
namespace {

constexpr glm::u8vec3 kWall{30, 30, 34}, kFloor{150, 148, 142};

/// The uses of random numbers; each has its own streams.
enum class CameraUse : std::uint64_t { calibration, color, frame };

/// The number of the stream for one use; `which` is below 2^48.
std::uint64_t stream(CameraUse use, std::uint64_t which) {
  return static_cast<std::uint64_t>(use) << 48 | which;
}

Result<void> check(const DepthCameraOptions& options) {
  const auto share = [](double x) { return x >= 0.0 && x <= 1.0; };
  const auto error = [](double x) { return x >= 0.0 && x <= 1.0; };
  if (!(options.cameras >= 1 && options.cameras <= 100 && options.radius > 0.0 &&
        options.radius <= 100.0 && options.half_field > 0.0 && options.half_field <= 5.0)) {
    return fail(ErrorCode::argument,
                "depth cameras must be 1 to 100 on a ring with a radius from 0 to 100 m, and have "
                "a field of view from 0 to 5");
  }
  if (!(options.pixel >= 2e-4)) {
    return fail(ErrorCode::argument,
                "the pixels of depth cameras must be at least 0.2 mm wide: ask for fewer points, "
                "or for more cameras");
  }
  if (!(error(options.noise) && share(options.noise_smooth) && options.grain >= 1 &&
        options.grain <= 1000 && error(options.depth_step) && share(options.least_cosine) &&
        options.least_cosine > 0.0 && share(options.least_cosine_varies) && share(options.flying) &&
        error(options.flying_reach) && error(options.baseline) &&
        error(options.calibration_shift) && error(options.calibration_turn) &&
        error(options.color_shift))) {
    return fail(ErrorCode::argument,
                "the noise, shares or errors of depth cameras are out of range");
  }
  return {};
}

/// What one camera of the rig gives in one frame.
class Shot {
 public:
  Shot(const Body& body, const SurfaceGrid& grid, const DepthCameraOptions& options,
       std::size_t number, std::uint64_t seed, int frame)
      : body_(body),
        grid_(grid),
        options_(options),
        distance_(working_distance(options)),
        number_(number),
        camera_(depth_camera_rig(options)[number]),
        frame_seed_(Random(Random(seed, stream(CameraUse::frame, number)).bits(),
                           static_cast<std::uint64_t>(static_cast<std::int64_t>(frame)))
                        .bits()) {
    const double per_axis = 1.0 / std::sqrt(3.0);
    calibration_ = random_calibration(Random(seed, stream(CameraUse::calibration, number)),
                                      per_axis * options.calibration_shift,
                                      per_axis * options.calibration_turn);
    Random random(seed, stream(CameraUse::color, number));
    color_x_ = options.color_shift / distance_ * random.normal();
    color_y_ = options.color_shift / distance_ * random.normal();
  }

  std::vector<DepthPoint> points() const {
    const DepthImage image =
        DepthImage::take(grid_, camera_.depth, options_, distance_, frame_seed_);
    std::vector<DepthPoint> points;
    for (int y = image.bottom(); y < image.top(); ++y) {
      for (int x = image.left(); x < image.right(); ++x) {
        if (image.at(x, y).measured == 0.0) continue;
        points.push_back(point(image, x, y));
      }
    }
    return points;
  }

 private:
  DepthPoint point(const DepthImage& image, int x, int y) const {
    const DepthPixel& pixel = image.at(x, y);
    const glm::dvec3 ray = image.ray(x, y);
    const glm::dvec3 target(0, options_.target, 0);
    const glm::dvec3 measured = camera_.depth.position + pixel.measured * ray;
    const glm::dvec3 normal = image.normal(x, y);
    DepthPoint point;
    point.position = calibration_.apply(measured - target) + target;
    point.normal = unit(normal + glm::cross(calibration_.turn, normal));
    point.truth = camera_.depth.position + pixel.truth * ray;
    point.color = color(measured, open(image, x, y) ? pixel.truth : 0.0);
    point.camera = static_cast<std::uint16_t>(number_);
    point.column = static_cast<std::uint16_t>(x);
    point.row = static_cast<std::uint16_t>(y);
    point.flying = pixel.flying;
    return point;
  }

  /// Whether nothing seems to hide from the colour camera the surface that a pixel sees. A ray of
  /// the colour camera may cross a part of the depth image before it gets there, because the colour
  /// image is shifted and because of the parallax of what is nearer.
  bool open(const DepthImage& image, int x, int y) const {
    const DepthPixel& pixel = image.at(x, y);
    if (pixel.flying) return false;
    const double parallax = options_.baseline * (1.0 / image.nearest() - 1.0 / pixel.truth);
    const auto reach = [&](double way) {
      return static_cast<int>(std::max(way, 0.0) * distance_ / options_.pixel) + 1;
    };
    return !image.anything_before(pixel.truth, x - reach(-color_x_), y - reach(-color_y_),
                                  x + reach(color_x_ + parallax), y + reach(color_y_));
  }

  /// The colour in the colour camera's image where the tool believes p to be. `depth` is that of
  /// the surface there; 0 if it is not known, near edges.
  glm::u8vec3 color(const glm::dvec3& p, double depth) const {
    const glm::dvec3 at = camera_.color.project(p);
    const double x = at.x + color_x_, y = at.y + color_y_;
    const glm::dvec3 way = camera_.color.toward(x, y);
    if (depth > 0.0) {
      const auto hit = hit_near(grid_, camera_.color.position, way, depth);
      if (hit) return color_at(body_, hit->primitive, hit->position);
    }
    if (std::abs(x) < options_.half_field && std::abs(y) < options_.half_field) {
      const auto hit = first_hit(grid_, {camera_.color.position, unit(way)});
      if (hit) return color_at(body_, hit->primitive, hit->position);
    }
    // The floor reaches to 3 m behind the middle.
    const double floor = -camera_.color.position.y / std::min(way.y, -1e-9);
    return floor < distance_ + 3.0 ? kFloor : kWall;
  }

  const Body& body_;
  const SurfaceGrid& grid_;
  const DepthCameraOptions& options_;
  double distance_;
  std::size_t number_;
  DepthCamera camera_;
  std::uint64_t frame_seed_;
  Calibration calibration_;
  double color_x_, color_y_;  ///< the shift of the colour image, in its picture plane
};

}  // namespace

double working_distance(const DepthCameraOptions& options) {
  const double below = options.low - options.target, above = options.high - options.target;
  const double square = options.radius * options.radius;
  return 0.5 * (std::sqrt(square + below * below) + std::sqrt(square + above * above));
}

std::vector<DepthCamera> depth_camera_rig(const DepthCameraOptions& options) {
  std::vector<DepthCamera> cameras;
  for (int i = 0; i < options.cameras; ++i) {
    const double angle = 2.0 * kPi * i / options.cameras;
    const Pinhole depth =
        look_at({options.radius * sine(angle), i % 2 == 0 ? options.high : options.low,
                 options.radius * cosine(angle)},
                {0, options.target, 0});
    Pinhole color = depth;
    color.position += options.baseline * depth.right;
    cameras.push_back({depth, color});
  }
  return cameras;
}

Result<std::vector<DepthPoint>> capture_depth(const Body& body, const DepthCameraOptions& options,
                                              std::uint64_t seed, int frame) {
  TRY(check(options));
  const auto grid = TRY(SurfaceGrid::build(body.surface));
  if (grid.cells().empty()) {
    return fail(ErrorCode::argument, "cannot sample a surface that has no area");
  }
  std::vector<std::vector<DepthPoint>> found(static_cast<std::size_t>(options.cameras));
  tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t i) {
    found[i] = Shot(body, grid, options, i, seed, frame).points();
  });
  std::size_t total = 0;
  for (const auto& some : found) total += some.size();
  std::vector<DepthPoint> points;
  points.reserve(total);
  for (const auto& some : found) points.insert(points.end(), some.begin(), some.end());
  return points;
}

}  // namespace pointreel
