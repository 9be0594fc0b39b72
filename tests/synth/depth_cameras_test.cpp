#include "datasets_synthetic/samplers/depth_cameras.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "codec/files/ply.h"
#include "datasets_synthetic/closest_point.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/ray_cast.h"
#include "datasets_synthetic/sequences.h"
#include "tests/synth/sampled_bytes.h"

namespace pointreel::depth_cameras_test {
namespace {

using Pixel = std::tuple<int, int, int>;  // camera, row, column

Pixel pixel_of(const DepthPoint& point) { return {point.camera, point.row, point.column}; }

/// Options without errors, and coarse enough for a fast test.
DepthCameraOptions exact() {
  DepthCameraOptions options;
  options.pixel = 0.02;
  options.noise = options.depth_step = options.flying = options.least_cosine_varies = 0.0;
  options.calibration_shift = options.calibration_turn = options.color_shift = 0.0;
  return options;
}

std::vector<DepthPoint> capture_walk(const DepthCameraOptions& options, std::uint64_t seed = 1,
                                     int frame = 12) {
  return capture_depth(pose_body(walk(0.4)), options, seed, frame).value();
}

/// A wall in front of the first camera of the rig.
struct Wall {
  double distance;     ///< from the camera, along its direction
  double radius;       ///< it is a disc
  double slant = 0.0;  ///< radians between its normal and the direction to the camera
  Material material = Material::skin;
};

/// The front sides of the walls are at their distances.
Body walls(const DepthCameraOptions& options, const std::vector<Wall>& all) {
  const Pinhole view = depth_camera_rig(options).front().depth;
  Body body;
  for (const Wall& wall : all) {
    constexpr double kThickness = 0.004;
    const glm::dvec3 axis = std::cos(wall.slant) * view.forward + std::sin(wall.slant) * view.right;
    const auto number = static_cast<std::uint16_t>(body.parts.size());
    body.surface.primitives.push_back(
        Disc{view.position + wall.distance * view.forward + kThickness * axis, axis, wall.radius,
             kThickness});
    body.surface.blends.push_back({number, number, 0.0});
    body.parts.push_back({Bone::chest, wall.material});
  }
  return body;
}

/// What the first camera of the rig alone measures.
std::vector<DepthPoint> capture_alone(const Body& body, DepthCameraOptions options, int frame = 0) {
  options.cameras = 1;
  return capture_depth(body, options, 1, frame).value();
}

double depth_of(const DepthCameraOptions& options, const glm::dvec3& p) {
  return depth_camera_rig(options)[0].depth.project(p).z;
}

double root_mean_square(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// The errors of depths on a wall.
std::vector<double> depth_errors(const DepthCameraOptions& options, const Wall& wall, int frames) {
  std::vector<double> errors;
  for (int frame = 0; frame < frames; ++frame) {
    for (const DepthPoint& point : capture_alone(walls(options, {wall}), options, frame)) {
      errors.push_back(depth_of(options, point.position) - depth_of(options, point.truth));
    }
  }
  return errors;
}

TEST(DepthCameras, stand_around_the_figure_and_look_at_it) {
  DepthCameraOptions options;
  const auto rig = depth_camera_rig(options);
  ASSERT_EQ(rig.size(), 8u);
  glm::dvec3 sum(0.0);
  for (const DepthCamera& camera : rig) {
    EXPECT_NEAR(std::hypot(camera.depth.position.x, camera.depth.position.z), options.radius, 1e-9);
    EXPECT_NEAR(glm::distance(camera.depth.position, camera.color.position), options.baseline,
                1e-9);
    EXPECT_EQ(camera.depth.forward, camera.color.forward);
    const glm::dvec3 target = camera.depth.project({0, options.target, 0});
    EXPECT_LT(std::hypot(target.x, target.y), 1e-9);
    EXPECT_NEAR(target.z, working_distance(options), 0.06);
    for (const double height : {0.0, 1.9}) {
      const glm::dvec3 at = camera.depth.project({0, height, 0});
      EXPECT_LT(std::max(std::abs(at.x), std::abs(at.y)), options.half_field);
    }
    sum += camera.depth.position;
  }
  EXPECT_LT(std::hypot(sum.x, sum.z), 1e-9);
  EXPECT_GT(rig[0].depth.position.z, 2.0) << "the first camera looks at the front";
}

TEST(DepthCameras, without_errors_points_are_visible_points_of_the_surface_on_rays_of_pixels) {
  const DepthCameraOptions options = exact();
  const auto rig = depth_camera_rig(options);
  const Surface surface = pose_body(walk(0.4)).surface;
  const SurfaceGrid grid = SurfaceGrid::build(surface).value();
  const auto points = capture_walk(options);
  ASSERT_GT(points.size(), 5000u);
  std::size_t hidden = 0, agree = 0;
  std::map<Pixel, int> pixels;
  for (const DepthPoint& point : points) {
    EXPECT_FALSE(point.flying);
    EXPECT_LT(glm::distance(point.position, point.truth), 1e-12);
    EXPECT_LT(std::abs(distance_to(surface, point.truth).distance.value), 1e-6);
    EXPECT_EQ(++pixels[pixel_of(point)], 1);
    const Pinhole& view = rig[point.camera].depth;
    const glm::dvec3 at = view.project(point.truth);
    const double pitch = options.pixel / working_distance(options);
    EXPECT_NEAR((at.x + options.half_field) / pitch - point.column, 0.5, 1e-6);
    EXPECT_NEAR((at.y + options.half_field) / pitch - point.row, 0.5, 1e-6);
    const glm::dvec3 way = point.truth - view.position;
    const auto hit = first_hit(grid, {view.position, way / glm::length(way)});
    hidden += !hit || hit->t < glm::length(way) - 1e-4;
    agree += glm::dot(distance_to(surface, point.truth).distance.gradient, point.normal) > 0.7;
  }
  // Rays between others that meet the same smooth piece are not cast, and something thin may hide
  // that piece.
  EXPECT_LE(hidden, points.size() / 500);
  EXPECT_GT(agree, points.size() * 85 / 100);
}

TEST(DepthCameras, several_cameras_sample_the_same_surface) {
  const auto points = capture_walk(exact());
  std::size_t again = 0, checked = 0;
  for (std::size_t i = 0; i < points.size(); i += 23) {
    ++checked;
    again += std::any_of(points.begin(), points.end(), [&](const DepthPoint& other) {
      return other.camera != points[i].camera &&
             glm::distance(other.truth, points[i].truth) < 0.025;
    });
  }
  EXPECT_GT(again, checked * 8 / 10);
}

TEST(DepthCameras, noise_grows_with_the_square_of_the_distance_and_with_the_slant) {
  DepthCameraOptions options = exact();
  options.pixel = 0.01;
  options.noise = 0.004;
  const double distance = working_distance(options);
  const auto deviation = [&](const Wall& wall) {
    const auto errors = depth_errors(options, wall, 4);
    EXPECT_GT(errors.size(), 2000u);
    double sum = 0.0;
    for (const double error : errors) sum += error;
    EXPECT_LT(std::abs(sum / static_cast<double>(errors.size())), 0.15 * options.noise);
    return root_mean_square(errors);
  };
  EXPECT_NEAR(deviation({distance, 0.25}) / options.noise, 1.0, 0.07);
  EXPECT_NEAR(deviation({0.6 * distance, 0.15}) / options.noise, 0.36, 0.03);
  EXPECT_NEAR(deviation({1.4 * distance, 0.4}) / options.noise, 1.96, 0.15);
  EXPECT_NEAR(deviation({distance, 0.35, std::acos(0.5)}) / options.noise, 2.0, 0.2);
}

TEST(DepthCameras, noise_is_similar_at_neighbouring_pixels_and_differs_from_frame_to_frame) {
  DepthCameraOptions options = exact();
  options.pixel = 0.01;
  options.noise = 0.004;
  const Body body = walls(options, {{working_distance(options), 0.3}});
  const auto errors = [&](int frame) {
    std::map<Pixel, double> all;
    for (const DepthPoint& point : capture_alone(body, options, frame)) {
      all[pixel_of(point)] = glm::dot(point.position - point.truth, point.truth) > 0.0
                                 ? glm::distance(point.position, point.truth)
                                 : -glm::distance(point.position, point.truth);
    }
    return all;
  };
  // The correlation between the pixels of `a` and those of `b` that lie `right` further right.
  const auto correlation = [&](const std::map<Pixel, double>& a, const std::map<Pixel, double>& b,
                               int right) {
    double both = 0.0, squares = 0.0;
    for (const auto& [pixel, error] : a) {
      const auto other =
          b.find({std::get<0>(pixel), std::get<1>(pixel), std::get<2>(pixel) + right});
      if (other == b.end()) continue;
      both += error * other->second;
      squares += 0.5 * (error * error + other->second * other->second);
    }
    return both / squares;
  };
  const auto first = errors(0), second = errors(1);
  ASSERT_GT(first.size(), 2000u);
  EXPECT_EQ(first.size(), second.size());
  EXPECT_GT(correlation(first, first, 1), 0.25);
  EXPECT_LT(correlation(first, first, 1), 0.55);
  EXPECT_LT(std::abs(correlation(first, first, 3 * options.grain)), 0.15);
  EXPECT_LT(std::abs(correlation(first, second, 0)), 0.15);
  options.noise_smooth = 0.0;
  const auto white = errors(0);
  EXPECT_LT(std::abs(correlation(white, white, 1)), 0.1);
}

TEST(DepthCameras, depths_come_in_steps_that_grow_with_the_square_of_the_distance) {
  DepthCameraOptions options = exact();
  options.noise = 0.004;
  options.depth_step = 0.003;
  const double distance = working_distance(options);
  for (const double times : {0.6, 1.0, 1.4}) {
    std::vector<double> depths;
    for (const DepthPoint& point :
         capture_alone(walls(options, {{times * distance, 0.3}}), options)) {
      depths.push_back(depth_of(options, point.position));
      const double disparity = distance * distance / options.depth_step / depths.back();
      EXPECT_NEAR(disparity, std::round(disparity), 1e-6);
    }
    std::sort(depths.begin(), depths.end());
    double step = 1.0;
    for (std::size_t i = 1; i < depths.size(); ++i) {
      const double gap = depths[i] - depths[i - 1];
      if (gap > 1e-9) step = std::min(step, gap);
    }
    EXPECT_NEAR(step / options.depth_step, times * times, 0.05 * times * times);
  }
}

TEST(DepthCameras, calibration_moves_each_camera_as_a_whole_and_the_same_in_every_frame) {
  DepthCameraOptions options = exact();
  options.cameras = 64;
  options.calibration_shift = 0.003;
  Body ball;  // so small and so near to the middle that turning does not move it
  ball.surface = {{RoundCone{{0, 0.9, 0}, {0, 0.9, 0}, 0.06, 0.06}}, {{0, 0, 0.0}}};
  ball.parts = {{Bone::chest, Material::skin}};
  const auto shifts = [&](std::uint64_t seed, int frame) {
    std::map<int, glm::dvec3> all;
    const auto points = capture_depth(ball, options, seed, frame).value();
    for (const DepthPoint& point : points) {
      const glm::dvec3 shift = point.position - point.truth;
      const auto [at, added] = all.try_emplace(point.camera, shift);
      EXPECT_LT(glm::distance(at->second, shift), 1e-12);
    }
    return all;
  };
  const auto first = shifts(1, 0), later = shifts(1, 5), other = shifts(2, 0);
  ASSERT_EQ(first.size(), 64u);
  std::vector<double> lengths;
  for (const auto& [camera, shift] : first) {
    EXPECT_LT(glm::distance(shift, later.at(camera)), 1e-12);
    EXPECT_GT(glm::distance(shift, other.at(camera)), 1e-5);
    lengths.push_back(glm::length(shift));
  }
  EXPECT_NEAR(root_mean_square(lengths), options.calibration_shift, 0.0005);

  options.calibration_shift = 0.0;
  options.calibration_turn = 0.0035;
  options.cameras = 8;
  for (const DepthPoint& point : capture_walk(options)) {
    const glm::dvec3 from = point.truth - glm::dvec3(0, options.target, 0);
    const glm::dvec3 moved = point.position - point.truth;
    EXPECT_LT(std::abs(glm::dot(from, moved)), 1e-9) << "a turn about the target";
    EXPECT_LT(glm::length(moved), 6.0 * options.calibration_turn * glm::length(from));
  }
}

TEST(DepthCameras, flying_pixels_hang_behind_silhouettes_or_between_two_surfaces) {
  DepthCameraOptions options = exact();
  options.flying = 0.5;
  const SurfaceGrid grid = SurfaceGrid::build(pose_body(walk(0.4)).surface).value();
  const auto points = capture_walk(options);
  std::size_t flying = 0, off = 0;
  for (const DepthPoint& point : points) {
    if (!point.flying) continue;
    ++flying;
    off += true_distance(grid, point.position) > 0.01;
    const Pinhole view = depth_camera_rig(options)[point.camera].depth;
    EXPECT_GE(view.project(point.position).z, view.project(point.truth).z - 1e-9);
  }
  EXPECT_GT(flying, points.size() / 100);
  EXPECT_LT(flying, points.size() / 3);
  EXPECT_GT(off, flying / 3);

  // Each is alone before the empty background, and one before the other.
  const double reach = options.flying_reach;
  for (const auto& [surfaces, nearest, farthest] :
       {std::tuple{std::vector<Wall>{{2.0, 0.3}}, 2.0, 2.0 + reach},
        std::tuple{std::vector<Wall>{{2.0, 0.2}, {2.6, 0.6}}, 2.0, 2.6 + reach}}) {
    std::size_t between = 0;
    for (const DepthPoint& point : capture_alone(walls(options, surfaces), options)) {
      const double depth = depth_of(options, point.position);
      EXPECT_GT(depth, nearest - 0.001);
      EXPECT_LT(depth, farthest);
      const bool off_walls = std::all_of(surfaces.begin(), surfaces.end(), [&](const Wall& wall) {
        return std::abs(depth - wall.distance) > 0.01;
      });
      EXPECT_LE(off_walls, point.flying);
      between += depth > 2.01 && depth < surfaces.back().distance - 0.01 && surfaces.size() > 1;
    }
    EXPECT_EQ(between > 10, surfaces.size() > 1);
  }
  options.flying = 0.0;
  for (const DepthPoint& point : capture_walk(options)) EXPECT_FALSE(point.flying);
}

TEST(DepthCameras, silhouettes_are_frayed_where_the_least_slant_varies) {
  DepthCameraOptions options = exact();
  const auto lost = [&] {
    std::map<Pixel, int> seen;
    for (const int frame : {0, 1}) {
      for (const DepthPoint& point : capture_walk(options, 1, frame)) ++seen[pixel_of(point)];
    }
    return std::count_if(seen.begin(), seen.end(), [](const auto& at) { return at.second == 1; });
  };
  EXPECT_EQ(lost(), 0);
  options.least_cosine_varies = 0.08;
  EXPECT_GT(lost(), 20);
}

TEST(DepthCameras, normals_face_the_camera_and_get_worse_with_the_noise) {
  DepthCameraOptions options = exact();
  options.pixel = 0.012;
  const Surface surface = pose_body(walk(0.4)).surface;
  const auto rig = depth_camera_rig(options);
  double before = 0.0;
  for (const double noise : {0.0, 0.003, 0.01}) {
    options.noise = noise;
    double angles = 0.0;
    const auto points = capture_walk(options);
    for (const DepthPoint& point : points) {
      EXPECT_NEAR(glm::length(point.normal), 1.0, 1e-12);
      // The calibration is exact here.
      EXPECT_GT(glm::dot(point.normal, rig[point.camera].depth.position - point.position), 0.0);
      const glm::dvec3 truth = distance_to(surface, point.truth).distance.gradient;
      angles += std::acos(std::clamp(glm::dot(glm::normalize(truth), point.normal), -1.0, 1.0));
    }
    const double mean = angles / static_cast<double>(points.size());
    EXPECT_GT(mean, before + 0.02) << noise;
    EXPECT_LT(mean, 0.9) << noise;
    before = mean;
  }
}

TEST(DepthCameras, colours_are_swapped_at_edges_only) {
  DepthCameraOptions options = exact();
  options.pixel = 0.008;
  const std::vector<Wall> pair = {{2.0, 0.25, 0.0, Material::skin},
                                  {2.6, 1.0, 0.0, Material::hair}};
  const Body body = walls(options, pair);
  // Skin is much lighter than hair, and redder than the floor.
  const auto is_skin = [](const DepthPoint& point) {
    return point.color.r > 120 && point.color.r > point.color.b + 30;
  };
  // Points of the near wall, and of the far one, with the colours of the other. They are at most
  // so far from the edge in the picture plane.
  const auto swapped = [&](double reach) {
    std::pair<int, int> count;
    for (const DepthPoint& point : capture_alone(body, options)) {
      const bool near = depth_of(options, point.truth) < 2.3;
      const bool skin = is_skin(point);
      if (near == skin) continue;
      const glm::dvec3 at = depth_camera_rig(options)[0].depth.project(point.truth);
      const double from_middle = std::hypot(at.x, at.y);
      if (from_middle > 0.3) continue;  // beside the far wall is the background
      EXPECT_LT(std::abs(from_middle - 0.25 / 2.0), reach);
      ++(near ? count.first : count.second);
    }
    return count;
  };
  options.baseline = 0.0;
  EXPECT_EQ(swapped(0.0), std::pair(0, 0));
  options.baseline = 0.05;
  const double parallax = options.baseline * (1.0 / 2.0 - 1.0 / 2.6);
  EXPECT_GT(swapped(parallax + 0.004).second, 20)
      << "the colour camera sees the near wall before the far one";
  options.color_shift = 0.01;
  EXPECT_GT(swapped(parallax + 0.03).first, 20) << "the colour image is shifted";

  // Before an empty background, the rim takes the colours of the room.
  const Body alone = walls(options, {pair[0]});
  const auto points = capture_alone(alone, options);
  const auto room = std::count_if(points.begin(), points.end(),
                                  [&](const DepthPoint& point) { return !is_skin(point); });
  EXPECT_GT(room, 5);
  EXPECT_LT(room, static_cast<std::ptrdiff_t>(points.size() / 3));
}

TEST(DepthCameras, a_seed_gives_the_same_bytes_on_one_thread_and_on_two) {
  SequenceOptions options;
  options.sampler = Sampler::depth_cameras;
  options.points = 8000;
  const Bytes one = sampled_bytes(options, 1);
  EXPECT_EQ(one, sampled_bytes(options, 2));
  options.seed = 2;
  EXPECT_NE(one, sampled_bytes(options, 2));
}

TEST(DepthCameras, frames_have_about_the_requested_number_of_points_with_normals_and_colours) {
  SequenceOptions options;
  options.sampler = Sampler::depth_cameras;
  const auto share = [&](const char* motion) {
    double sum = 0.0;
    for (const int frame : {0, 20, 40}) {
      const PointCloud cloud = sequence_frame(*find_motion(motion), options, frame).value();
      EXPECT_EQ(cloud.normals.size(), cloud.size());
      EXPECT_EQ(cloud.colors.size(), cloud.size());
      sum += static_cast<double>(cloud.size()) / 3.0;
    }
    return sum / static_cast<double>(options.points);
  };
  for (const std::size_t points : {std::size_t{6000}, std::size_t{30000}}) {
    options.points = points;
    EXPECT_NEAR(share("walk"), 1.0, 0.08) << points;
  }
  options.depth_cameras.cameras = 5;
  EXPECT_NEAR(share("walk"), 1.0, 0.12);
}

TEST(DepthCameras, measure_a_figure_that_can_be_compared_with_the_truth) {
  SequenceOptions options;
  options.sampler = Sampler::depth_cameras;
  options.points = 8000;
  std::vector<double> medians;
  for (const double noise : {0.003, 0.01}) {
    options.depth_cameras.noise = noise;
    const PointCloud cloud = sequence_frame(*find_motion("walk"), options, 9).value();
    const Body body = pose_body(frame_pose(*find_motion("walk"), options, 9));
    auto distances = true_distances(SurfaceGrid::build(body.surface).value(), cloud);
    std::sort(distances.begin(), distances.end());
    medians.push_back(distances[distances.size() / 2]);
    EXPECT_LT(distances[distances.size() * 99 / 100], 0.3);
  }
  EXPECT_GT(medians[0], 0.001);
  EXPECT_LT(medians[0], 0.004);
  EXPECT_GT(medians[1], 0.004);
  EXPECT_LT(medians[1], 0.012);
}

TEST(DepthCameras, refuses_options_out_of_range) {
  const Body body = pose_body(walk(0.0));
  const auto refuses = [&](const std::function<void(DepthCameraOptions&)>& change) {
    DepthCameraOptions options = exact();
    options.pixel = 0.1;
    change(options);
    const auto points = capture_depth(body, options, 1, 0);
    return !points && points.error().code == ErrorCode::argument;
  };
  EXPECT_FALSE(refuses([](DepthCameraOptions&) {}));
  EXPECT_FALSE(refuses([](DepthCameraOptions& o) { o.cameras = 1; }));
  EXPECT_TRUE(refuses([](DepthCameraOptions& o) { o.cameras = 0; }));
  EXPECT_TRUE(refuses([](DepthCameraOptions& o) { o.cameras = 101; }));
  EXPECT_TRUE(refuses([](DepthCameraOptions& o) { o.radius = 0.0; }));
  EXPECT_TRUE(refuses([](DepthCameraOptions& o) { o.half_field = 6.0; }));
  EXPECT_TRUE(refuses([](DepthCameraOptions& o) { o.pixel = 1e-4; }));
  EXPECT_TRUE(refuses([](DepthCameraOptions& o) { o.pixel = std::nan(""); }));
  EXPECT_TRUE(refuses([](DepthCameraOptions& o) { o.noise = -1e-3; }));
  EXPECT_TRUE(refuses([](DepthCameraOptions& o) { o.noise_smooth = 1.5; }));
  EXPECT_TRUE(refuses([](DepthCameraOptions& o) { o.grain = 0; }));
  EXPECT_TRUE(refuses([](DepthCameraOptions& o) { o.depth_step = -1.0; }));
  EXPECT_TRUE(refuses([](DepthCameraOptions& o) { o.least_cosine = 0.0; }));
  EXPECT_TRUE(refuses([](DepthCameraOptions& o) { o.flying = 2.0; }));
  EXPECT_TRUE(refuses([](DepthCameraOptions& o) { o.calibration_shift = std::nan(""); }));
}

TEST(StillSequence, shows_the_first_pose_in_every_frame_with_new_noise) {
  const Motion& motion = *find_motion("walk");
  for (const Sampler sampler :
       {Sampler::scan, Sampler::uniform, Sampler::ldc, Sampler::depth_cameras}) {
    SequenceOptions options;
    options.sampler = sampler;
    options.points = 3000;
    options.ldc.spacing = 0.03;
    const PointCloud moving = sequence_frame(motion, options, 0).value();
    options.still = true;
    const PointCloud first = sequence_frame(motion, options, 0).value();
    const PointCloud later = sequence_frame(motion, options, 20).value();
    EXPECT_EQ(first.positions, moving.positions);
    // A layered depth cube has the same rays in every frame.
    EXPECT_EQ(later.positions == first.positions, sampler == Sampler::ldc);
    const SurfaceGrid grid = SurfaceGrid::build(pose_body(motion.pose(0.0)).surface).value();
    const auto median = [&](const PointCloud& cloud) {
      auto distances = true_distances(grid, cloud);
      std::nth_element(distances.begin(), distances.begin() + 1000, distances.end());
      return distances[1000];
    };
    EXPECT_LT(median(later), 0.004);
    options.still = false;
    EXPECT_GT(median(sequence_frame(motion, options, 20).value()), 0.008) << "the figure walks";
  }
}

}  // namespace
}  // namespace pointreel::depth_cameras_test
