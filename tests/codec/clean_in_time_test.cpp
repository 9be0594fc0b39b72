#include "codec/surface/clean_in_time.h"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "codec/surface/surface_motion.h"
#include "common/threads/tbb_executor.h"

namespace pointreel::clean_in_time_test {
namespace {

constexpr double kNoise = 0.02;
const glm::dvec3 kAxes(1.0, 0.7, 0.5);  ///< of an ellipsoid, which cannot slide on itself

/// A surface that rests at x < 0 and has its other half turned about the y axis.
struct Pose {
  double turn = 0.0;      ///< of the half at x > 0, in radians
  glm::dvec3 shift{0.0};  ///< of all

  glm::dmat3 rotation(double x) const {
    const double angle = turn * std::clamp(x / 0.5, 0.0, 1.0);
    return glm::dmat3(std::cos(angle), 0, -std::sin(angle), 0, 1, 0, std::sin(angle), 0,
                      std::cos(angle));
  }
  glm::dvec3 operator()(const glm::dvec3& p) const { return rotation(p.x) * p + shift; }
};

struct Sample {
  PointCloud cloud;                 ///< with noise, normals and colours
  std::vector<glm::dvec3> resting;  ///< where its points are on the ellipsoid
};

Sample sample(const Pose& pose, unsigned seed, double noise = kNoise) {
  constexpr std::size_t count = 20'000;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return glm::dvec3(normal(random), normal(random), normal(random)); };
  Sample out;
  out.cloud.origin = glm::dvec3(100.0, -5.0, 3.0);
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3 at = kAxes * glm::normalize(vector());
    const glm::dvec3 n = pose.rotation(at.x) * glm::normalize(at / (kAxes * kAxes));
    out.resting.push_back(at);
    out.cloud.positions.emplace_back(pose(at) + noise * vector());
    out.cloud.normals.emplace_back(glm::normalize(n + 0.2 * vector()));
    out.cloud.colors.emplace_back(i & 0xff, i >> 8 & 0xff, 7);
  }
  return out;
}

/// Of the points of a cloud without a turned half from the ellipsoid, root mean square.
double distance(const PointCloud& cloud, const glm::dvec3& shift) {
  double sum = 0.0;
  for (const glm::vec3& position : cloud.positions) {
    const glm::dvec3 p = glm::dvec3(position) - shift, q = p / kAxes;
    // To first order.
    const double value = glm::length(q) - 1.0;
    sum += std::pow(value / glm::length(q / kAxes / glm::length(q)), 2.0);
  }
  return std::sqrt(sum / static_cast<double>(cloud.size()));
}

CleanedFrame cleaned(const Pose& pose, unsigned seed) {
  return clean_alone(sample(pose, seed).cloud, {}, tbb_executor());
}

std::vector<const CleanedFrame*> pointers(const std::vector<CleanedFrame>& frames) {
  std::vector<const CleanedFrame*> out;
  for (const CleanedFrame& frame : frames) out.push_back(&frame);
  return out;
}

TEST(SurfaceMotion, follows_parts_that_rest_turn_and_shift) {
  const Pose before{0.0, {}}, after{0.3, {0.02, 0.05, 0.0}};
  const Sample from = sample(before, 1);
  const CleanedFrame a = clean_alone(from.cloud, {}), b = cleaned(after, 2);
  ASSERT_TRUE(a.report.cleaned && b.report.cleaned);
  const auto motions = surface_motion(a.pieces, a.cloud.positions, b.pieces, 0.03f);
  double squares = 0.0;
  std::size_t found = 0;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (!motions[i]) continue;
    ++found;
    // Cleaning has removed some points. Colours tell the others.
    const glm::u16vec3 color = a.before.colors[i];
    const glm::dvec3 at = from.resting[color.x + 256u * color.y];
    const glm::dvec3 moved((*motions[i])(glm::vec3(at)));
    const glm::dvec3 n = after.rotation(at.x) * glm::normalize(at / (kAxes * kAxes));
    squares += std::pow(glm::dot(moved - after(at), n), 2.0);
  }
  EXPECT_GT(static_cast<double>(found), 0.95 * static_cast<double>(motions.size()));
  EXPECT_LT(std::sqrt(squares / static_cast<double>(found)), 0.6 * kNoise);
}

TEST(SurfaceMotion, leaves_what_rests_exactly_where_it_is) {
  const CleanedFrame a = cleaned({}, 1), b = cleaned({}, 2);
  for (const auto& motion : surface_motion(a.pieces, a.cloud.positions, b.pieces, 0.03f))
    if (motion) EXPECT_LT(glm::distance(motion->from, motion->to), 1e-6f);
}

TEST(SurfaceMotion, finds_nothing_where_the_surface_is_not) {
  const CleanedFrame a = cleaned({}, 1), b = cleaned({0.0, {5.0, 0.0, 0.0}}, 2);
  for (const auto& motion : surface_motion(a.pieces, a.cloud.positions, b.pieces, 0.03f))
    EXPECT_FALSE(motion);
}

TEST(SurfaceMotion, bears_positions_beyond_any_grid) {
  PointCloud cloud;
  for (const float x : {-3e38f, -1e20f, 0.0f, 1e-30f, 1e20f, 3e38f}) {
    cloud.positions.emplace_back(x, 0.0f, -x);
    cloud.normals.emplace_back(0.0f, 1.0f, 0.0f);
  }
  const SurfacePyramid pieces = surface_pyramid(cloud, 1e-3f);
  EXPECT_EQ(surface_motion(pieces, cloud.positions, pieces, 1.0f).size(), cloud.size());
}

TEST(CleanInTime, is_nearer_to_the_surface_than_cleaning_alone) {
  const glm::dvec3 step(0.03, 0.0, 0.01);
  std::vector<CleanedFrame> around;
  for (const int i : {-2, -1, 1, 2})
    around.push_back(cleaned({0.0, static_cast<double>(i) * step}, static_cast<unsigned>(10 + i)));
  const CleanedFrame frame = cleaned({}, 1);
  const auto in_time = clean_in_time(frame, pointers(around), {}, tbb_executor());
  ASSERT_TRUE(in_time);
  EXPECT_EQ(in_time->cloud.size(), frame.cloud.size());
  EXPECT_EQ(in_time->cloud.normals.size(), frame.cloud.size());
  EXPECT_EQ(in_time->report.removed, frame.report.removed);
  EXPECT_LT(in_time->report.radius, frame.report.radius);
  EXPECT_LT(distance(in_time->cloud, {}), 0.85 * distance(frame.cloud, {}));
}

TEST(CleanInTime, what_begins_to_move_leaves_no_ghost) {
  // It rests for two frames, then jumps further than its surface extends.
  std::vector<CleanedFrame> around;
  around.push_back(cleaned({}, 2));
  around.push_back(cleaned({}, 3));
  around.push_back(cleaned({0.0, {0.5, 0.0, 0.0}}, 4));
  around.push_back(cleaned({0.0, {1.0, 0.0, 0.0}}, 5));
  const CleanedFrame frame = cleaned({}, 1);
  const auto in_time = clean_in_time(frame, pointers(around), {}, tbb_executor());
  ASSERT_TRUE(in_time);
  EXPECT_LT(distance(in_time->cloud, {}), distance(frame.cloud, {}));
}

TEST(CleanInTime, frames_that_have_nothing_in_common_change_little) {
  std::vector<CleanedFrame> around;
  around.push_back(cleaned({0.0, {9.0, 0.0, 0.0}}, 2));
  const CleanedFrame frame = cleaned({}, 1);
  const auto in_time = clean_in_time(frame, pointers(around), {});
  ASSERT_TRUE(in_time);
  EXPECT_NEAR(in_time->report.radius, frame.report.radius, 1e-3);
  EXPECT_LT(distance(in_time->cloud, {}), 1.1 * distance(frame.cloud, {}));
}

TEST(CleanInTime, only_frames_with_the_same_attributes_count) {
  PointCloud bare = sample({}, 2).cloud;
  bare.colors.clear();
  std::vector<CleanedFrame> around;
  around.push_back(clean_alone(bare, {}));
  around.push_back(clean_alone({}, {}));
  around.push_back(cleaned({}, 1));
  EXPECT_FALSE(clean_in_time(cleaned({}, 1), pointers(around), {}));
  EXPECT_FALSE(clean_in_time(cleaned({}, 1), {}, {}));
  EXPECT_FALSE(clean_in_time(around[1], pointers(around), {}));
}

TEST(CleanInTime, colours_that_change_are_those_of_the_frame) {
  const auto colored = [](unsigned seed, const glm::u16vec3& color) {
    PointCloud cloud = sample({}, seed).cloud;
    cloud.colors.assign(cloud.size(), color);
    return clean_alone(cloud, {}, tbb_executor());
  };
  const glm::u16vec3 blue(0, 0, 65535), red(65535, 0, 0);
  std::vector<CleanedFrame> around;
  around.push_back(colored(2, red));
  around.push_back(colored(3, red));
  const CleanedFrame frame = colored(1, blue);
  const auto in_time = clean_in_time(frame, pointers(around), {}, tbb_executor());
  ASSERT_TRUE(in_time);
  std::size_t mixed = 0;
  for (const glm::u16vec3& color : in_time->cloud.colors) mixed += color.x > 2570 ? 1 : 0;
  EXPECT_LT(static_cast<double>(mixed), 0.01 * static_cast<double>(frame.cloud.size()));
}

TEST(CleanInTime, leaves_frames_with_little_noise_to_cleaning_alone) {
  std::vector<CleanedFrame> around;
  around.push_back(clean_alone(sample({}, 2, 0.15 * kNoise).cloud, {}));
  const CleanedFrame frame = clean_alone(sample({}, 1, 0.15 * kNoise).cloud, {});
  ASSERT_TRUE(frame.report.cleaned);
  EXPECT_FALSE(clean_in_time(frame, pointers(around), {}));
}

TEST(CleanInTime, does_not_depend_on_the_executor) {
  std::vector<CleanedFrame> around;
  around.push_back(cleaned({0.1, {}}, 2));
  around.push_back(cleaned({-0.1, {}}, 3));
  const CleanedFrame frame = cleaned({}, 1);
  const auto one = clean_in_time(frame, pointers(around), {});
  const auto many = clean_in_time(frame, pointers(around), {}, tbb_executor());
  ASSERT_TRUE(one && many);
  EXPECT_EQ(one->cloud.positions, many->cloud.positions);
  EXPECT_EQ(one->cloud.normals, many->cloud.normals);
  EXPECT_EQ(one->cloud.colors, many->cloud.colors);
}

}  // namespace
}  // namespace pointreel::clean_in_time_test
