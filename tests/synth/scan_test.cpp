#include "datasets_synthetic/samplers/scan.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "codec/files/ply.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/random.h"
#include "datasets_synthetic/samplers/depth_range.h"
#include "datasets_synthetic/sequences.h"
#include "tests/synth/sampled_bytes.h"

namespace pointreel::scan_test {
namespace {

/// Options coarse enough for a fast test.
ScanOptions coarse() {
  ScanOptions options;
  options.curve_spacing = 0.06;
  options.pixel = 0.004;
  return options;
}

std::vector<ScanPoint> scan_walk(const ScanOptions& options, std::uint64_t seed = 1,
                                 int frame = 12) {
  return scan(pose_body(walk(0.4)), options, seed, frame).value();
}

double value_at(const Surface& surface, const glm::dvec3& p) {
  return distance_to(surface, p).distance.value;
}

/// Whether nothing blocks the straight line between two points outside, by steps of the full
/// distance.
bool clear(const Surface& surface, const glm::dvec3& from, const glm::dvec3& to) {
  const glm::dvec3 way = to - from;
  const double length = glm::length(way);
  for (double t = 0.0; t < length;) {
    const double value = value_at(surface, from + way * (t / length));
    if (value < 0.0) return false;
    t += std::max(value, 2e-4);
  }
  return true;
}

TEST(ScanRig, places_its_devices_around_the_scene_and_points_them_at_it) {
  const Rig rig = make_rig({});
  ASSERT_EQ(rig.projectors.size(), rig.cameras.size());
  ASSERT_EQ(rig.pairs.size(), 2 * rig.projectors.size());
  for (const auto* views : {&rig.projectors, &rig.cameras}) {
    for (const Pinhole& view : *views) {
      EXPECT_NEAR(std::hypot(view.position.x, view.position.z), 3.0, 1e-9);
      const glm::dvec3 target = view.project({0, 0.9, 0});
      EXPECT_NEAR(target.x, 0.0, 1e-9);
      EXPECT_NEAR(target.y, 0.0, 1e-9);
      EXPECT_NEAR(target.z, glm::length(view.position - glm::dvec3(0, 0.9, 0)), 1e-9);
      EXPECT_GT(view.project({0, 1.9, 0}).y, 0.2);  // upright
      EXPECT_NEAR(glm::determinant(glm::dmat3(view.right, view.up, -view.forward)), 1.0, 1e-12);
      // A point in the direction (x, y) is seen at (x, y).
      const glm::dvec3 back = view.project(view.position + 2.5 * view.toward(0.3, -0.2));
      EXPECT_LT(glm::length(back - glm::dvec3(0.3, -0.2, 2.5)), 1e-9);
    }
  }
  for (const Rig::Pair& pair : rig.pairs) {
    // The cameras of a projector are next to it.
    for (const Pinhole& other : rig.cameras) {
      EXPECT_LE(
          glm::distance(rig.projectors[pair.projector].position, rig.cameras[pair.camera].position),
          glm::distance(rig.projectors[pair.projector].position, other.position) + 0.6);
    }
  }
}

TEST(DepthRange, contains_the_distance_of_every_point_of_the_surface) {
  const Surface surface = pose_body(walk(0.4)).surface;
  const SurfaceGrid grid = SurfaceGrid::build(surface).value();
  const Pinhole view = look_at({1.0, 1.7, 2.0}, {0, 0.9, 0});
  const DepthRange ranges(grid, view, 0.8);
  std::size_t empty = 0;
  for (const ScanPoint& point : scan_walk(coarse())) {
    const glm::dvec3 at = view.project(point.truth);
    ASSERT_TRUE(std::abs(at.x) < 0.8 && std::abs(at.y) < 0.8);
    const auto range = ranges.at(ranges.tile_of(at.x), ranges.tile_of(at.y));
    const double distance = glm::length(point.truth - view.position);
    EXPECT_LE(range.near, distance);
    EXPECT_GE(range.far, distance);
  }
  for (int y = 0; y < ranges.tiles(); ++y) {
    for (int x = 0; x < ranges.tiles(); ++x) empty += ranges.at(x, y).empty();
  }
  EXPECT_GT(empty, static_cast<std::size_t>(ranges.tiles() * ranges.tiles() / 2));
}

TEST(Scan, points_without_errors_lie_on_lit_and_visible_parts_of_the_surface) {
  ScanOptions options = coarse();
  options.noise = options.outliers = options.calibration_shift = options.calibration_turn = 0.0;
  const Surface surface = pose_body(walk(0.4)).surface;
  const Rig rig = make_rig(options.rig);
  const auto points = scan_walk(options);
  ASSERT_GT(points.size(), 5000u);
  std::size_t hidden = 0, checked = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const ScanPoint& point = points[i];
    EXPECT_EQ(point.position, point.truth);
    EXPECT_LE(std::abs(value_at(surface, point.truth)), 1e-7);
    if (i % 9 != 0) continue;
    ++checked;
    const glm::dvec3 outside = point.truth + 2e-5 * point.normal;
    for (const glm::dvec3& device : {rig.projectors[rig.pairs[point.pair].projector].position,
                                     rig.cameras[rig.pairs[point.pair].camera].position}) {
      const glm::dvec3 way = device - point.truth;
      EXPECT_GT(glm::dot(way, point.normal), 0.9 * options.least_cosine * glm::length(way));
      hidden += !clear(surface, outside, device);
    }
  }
  // The curve is followed in steps, and something thin may lie between two of them.
  EXPECT_LE(hidden, checked / 500);
}

TEST(Scan, points_lie_on_curves_of_the_pattern_at_whole_pixels) {
  ScanOptions options = coarse();
  const Rig rig = make_rig(options.rig);
  const double pixel = options.pixel / working_distance(options.rig);
  const double spacing = options.curve_spacing / working_distance(options.rig);
  double phases[2] = {-1.0, -1.0};
  std::size_t off = 0, count = 0;
  for (const ScanPoint& point : scan_walk(options)) {
    const glm::dvec3 lit = rig.projectors[rig.pairs[point.pair].projector].project(point.truth);
    const glm::dvec3 seen = rig.cameras[rig.pairs[point.pair].camera].project(point.truth);
    if (rig.pairs[point.pair].projector != 0) continue;
    const double across = (point.family == 0 ? lit.x : lit.y) / spacing;
    double& phase = phases[point.family];
    if (phase < 0.0) phase = across - point.curve;
    EXPECT_NEAR(across - point.curve, phase, 1e-6);
    // The crossing is interpolated between two steps.
    const double row = (point.family == 0 ? seen.y : seen.x) / pixel;
    off += std::abs(row - std::round(row)) > 0.15;
    ++count;
  }
  ASSERT_GT(count, 1000u);
  EXPECT_LT(off, count / 10);
}

TEST(Scan, errors_follow_the_options) {
  ScanOptions options = coarse();
  options.outliers = 0.01;
  options.calibration_shift = options.calibration_turn = 0.0;
  const Rig rig = make_rig(options.rig);
  double squares = 0.0, along = 0.0, previous = 0.0;
  std::size_t count = 0, outliers = 0;
  const auto points = scan_walk(options);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const ScanPoint& point = points[i];
    const glm::dvec3 error = point.position - point.truth;
    const glm::dvec3 way = rig.cameras[rig.pairs[point.pair].camera].position - point.truth;
    const glm::dvec3 ray = way / glm::length(way);
    // The error is along the ray of the camera only.
    EXPECT_NEAR(std::abs(glm::dot(error, ray)), glm::length(error), 1e-12);
    if (point.outlier) {
      ++outliers;
      EXPECT_LE(glm::length(error), options.outlier_reach + 0.02);
      continue;
    }
    const double far = glm::length(way) / working_distance(options.rig);
    const double sigma = options.noise * far * far / glm::dot(ray, point.normal);
    const double scaled = glm::dot(error, ray) / sigma;
    EXPECT_LT(std::abs(scaled), 6.0);
    squares += scaled * scaled;
    const bool follows = i > 0 && points[i - 1].curve == point.curve &&
                         glm::distance(points[i - 1].truth, point.truth) < 0.006;
    if (follows) along += scaled * previous;
    previous = scaled;
    ++count;
  }
  const double total = static_cast<double>(count);
  EXPECT_NEAR(std::sqrt(squares / total), 1.0, 0.05);
  EXPECT_NEAR(static_cast<double>(outliers) / total, 0.01, 0.004);
  EXPECT_GT(along / total, 0.3);  // neighbours on a curve have similar errors
  EXPECT_LT(along / total, 0.65);
}

TEST(Scan, calibration_errors_shift_each_device_as_a_whole_and_stay_constant) {
  ScanOptions options = coarse();
  options.noise = options.outliers = 0.0;
  std::map<int, glm::dvec3> sums[2];
  std::map<int, double> counts[2];
  for (const int frame : {0, 1}) {
    for (const ScanPoint& point : scan_walk(options, 3, frame)) {
      const glm::dvec3 error = point.position - point.truth;
      EXPECT_LT(glm::length(error), 0.008);
      sums[frame][point.pair] += error;
      counts[frame][point.pair] += 1.0;
    }
  }
  double largest = 0.0;
  for (const auto& [pair, sum] : sums[0]) {
    const glm::dvec3 mean = sum / counts[0][pair];
    largest = std::max(largest, glm::length(mean));
    EXPECT_LT(glm::distance(mean, sums[1][pair] / counts[1][pair]), 1e-4);
  }
  EXPECT_EQ(sums[0].size(), make_rig(options.rig).pairs.size());
  EXPECT_GT(largest, options.calibration_shift);
}

TEST(Scan, points_are_close_along_curves_and_far_across) {
  ScanOptions options = coarse();
  const auto points = scan_walk(options);
  // Within a pair and family: the next point of the curve, and the nearest point of the next curve.
  std::vector<double> along, across;
  for (std::size_t i = 0; i + 1 < points.size(); i += 13) {
    const ScanPoint& point = points[i];
    double same = 1.0, other = 1.0;
    for (const ScanPoint& p : points) {
      if (p.pair != point.pair || p.family != point.family || &p == &point) continue;
      double& nearest = p.curve == point.curve ? same : other;
      nearest = std::min(nearest, glm::distance(p.truth, point.truth));
    }
    along.push_back(same);
    across.push_back(other);
  }
  const auto median = [](std::vector<double>& v) {
    std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
    return v[v.size() / 2];
  };
  const double a = median(along), b = median(across);
  EXPECT_GT(a, 0.7 * options.pixel);
  EXPECT_LT(a, 2.0 * options.pixel);
  EXPECT_GT(b, 0.6 * options.curve_spacing);
  EXPECT_LT(b, 1.6 * options.curve_spacing);
}

TEST(Scan, patches_and_dark_surfaces_have_fewer_points) {
  ScanOptions options = coarse();
  const Body body = pose_body(walk(0.4));
  const auto dark = [&](const std::vector<ScanPoint>& points) {
    return std::count_if(points.begin(), points.end(), [&](const ScanPoint& p) {
      return body.parts[p.primitive].material == Material::hair;
    });
  };
  options.patches = 0;
  options.lost_dark = 0.0;
  const auto all = scan_walk(options);
  options.lost_dark = 0.6;
  const auto fewer = scan_walk(options);
  EXPECT_GT(dark(all), 100);
  EXPECT_LT(static_cast<double>(dark(fewer)), 0.65 * static_cast<double>(dark(all)));
  options.patches = 20;
  options.patch_radius = 0.1;
  EXPECT_LT(static_cast<double>(scan_walk(options).size()),
            0.97 * static_cast<double>(fewer.size()));
  options.lost = 0.5;
  EXPECT_LT(static_cast<double>(scan_walk(options).size()),
            0.6 * static_cast<double>(fewer.size()));
}

TEST(Scan, the_pattern_and_its_gaps_differ_between_frames_and_seeds) {
  const auto first = scan_walk(coarse());
  const auto positions = [](const std::vector<ScanPoint>& points) {
    std::vector<std::tuple<double, double, double>> all;
    for (const ScanPoint& p : points) all.emplace_back(p.truth.x, p.truth.y, p.truth.z);
    std::sort(all.begin(), all.end());
    return all;
  };
  for (const auto& [seed, frame] : {std::pair{1, 13}, std::pair{2, 12}}) {
    const auto second = scan_walk(coarse(), static_cast<std::uint64_t>(seed), frame);
    const auto a = positions(first), b = positions(second);
    std::vector<std::tuple<double, double, double>> both;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
    EXPECT_LT(both.size(), a.size() / 100);
    EXPECT_NEAR(static_cast<double>(a.size()), static_cast<double>(b.size()),
                0.1 * static_cast<double>(a.size()));
  }
}

TEST(Scan, a_seed_gives_the_same_bytes_on_one_thread_and_on_two) {
  SequenceOptions options;
  options.points = 8000;
  const Bytes one = sampled_bytes(options, 1);
  EXPECT_EQ(one, sampled_bytes(options, 2));
  EXPECT_EQ(one, sampled_bytes(options, 1));
  options.seed = 2;
  EXPECT_NE(one, sampled_bytes(options, 2));
}

TEST(Scan, frames_have_about_the_requested_number_of_points_and_outward_normals) {
  const Motion& motion = *find_motion("walk");
  SequenceOptions options;
  for (const std::size_t points : {std::size_t{6000}, std::size_t{30000}}) {
    options.points = points;
    double sum = 0.0;
    for (const int frame : {0, 20, 40}) {
      const auto cloud = sequence_frame(motion, options, frame);
      ASSERT_TRUE(cloud) << cloud.error().message;
      sum += static_cast<double>(cloud->size()) / 3.0;
      ASSERT_EQ(cloud->normals.size(), cloud->size());
      ASSERT_EQ(cloud->radii.size(), cloud->size());
      ASSERT_EQ(cloud->colors.size(), cloud->size());
    }
    EXPECT_NEAR(sum / static_cast<double>(points), 1.0, 0.05) << points;
  }
  const auto cloud = sequence_frame(motion, options, 12);
  const Surface surface = pose_body(motion.pose(12 / kPosesPerSecond)).surface;
  std::size_t outwards = 0, checked = 0;
  for (std::size_t i = 0; i < cloud->size(); i += 7) {
    const Distance at =
        distance_to(surface, glm::dvec3(cloud->positions[i]) + cloud->origin).distance;
    outwards += glm::dot(at.gradient, glm::dvec3(cloud->normals[i])) > 0.0;
    ++checked;
  }
  EXPECT_GT(static_cast<double>(outwards), 0.98 * static_cast<double>(checked));
}

TEST(Scan, refuses_options_out_of_range) {
  const Body body = pose_body(walk(0.0));
  const auto refuses = [&](const auto& change) {
    ScanOptions options = coarse();
    change(options);
    return !scan(body, options, 1, 0).has_value();
  };
  EXPECT_TRUE(refuses([](ScanOptions& o) { o.rig.projectors = 1; }));
  EXPECT_TRUE(refuses([](ScanOptions& o) { o.curve_spacing = 0.0; }));
  EXPECT_TRUE(refuses([](ScanOptions& o) { o.pixel = NAN; }));
  EXPECT_TRUE(refuses([](ScanOptions& o) { o.least_cosine = 1.0; }));
  EXPECT_TRUE(refuses([](ScanOptions& o) { o.lost = 1.5; }));
  EXPECT_FALSE(scan(Body{}, coarse(), 1, 0).has_value());
}

}  // namespace
}  // namespace pointreel::scan_test
