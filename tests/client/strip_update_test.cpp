#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "client/strips/strips.h"
#include "codec/core/build.h"
#include "tests/executors.h"

namespace pointreel::strip_update_test {
namespace {

constexpr Cube kCube{.origin = {-1.3, -1.3, -1.3}, .edge = 2.6};

/// One point of a surface, which is all of its leaf.
struct Point {
  glm::vec3 position, normal;
  float radius = 0.03f;
  glm::u16vec3 color{30000};
};

struct Frame {
  Svo svo;
  NodeAttributes attributes;
  std::vector<glm::vec3> positions, normals;
  std::vector<float> radii;
  bool lines = false;

  StripSurfels surfels() const { return {svo, positions, normals, radii, lines}; }
};

Frame frame_of(const std::vector<Point>& points, int depth = 7, const Cube& cube = kCube) {
  PointCloud cloud;
  for (const Point& point : points) {
    cloud.positions.push_back(point.position);
    cloud.normals.push_back(point.normal);
    cloud.colors.push_back(point.color);
  }
  const SortedPoints sorted = sort_points(cloud, cube, depth);
  Frame frame;
  frame.svo = build_svo(sorted, depth);
  frame.attributes = mean_attributes(frame.svo, cloud, sorted);
  std::uint64_t last = ~std::uint64_t{0};
  for (const KeyIndex& item : sorted.points) {
    if (std::exchange(last, item.key) == item.key) continue;
    const Point& point = points[item.index];
    frame.positions.push_back(point.position - glm::vec3(cube.origin));
    frame.normals.push_back(point.normal);
    frame.radii.push_back(point.radius);
  }
  return frame;
}

/// A sphere with bumps.
std::vector<Point> body() {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  std::vector<Point> points;
  for (int i = 0; i < 12'000; ++i) {
    const glm::vec3 n = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
    points.push_back({n * (1.0f + 0.05f * std::sin(9.0f * n.x) * std::cos(7.0f * n.y)), n});
  }
  return points;
}

/// A random change of a part of a surface, or of nothing.
void change(std::vector<Point>& points, std::mt19937& random) {
  const glm::vec3 center = points[random() % points.size()].position;
  const float reach = 0.05f + 0.3f * static_cast<float>(random() % 1000) / 1000.0f;
  const auto near = [&](const Point& point) {
    return glm::length(point.position - center) < reach;
  };
  switch (random() % 8) {
    case 0:
      return;
    case 1:
      std::erase_if(points, near);
      return;
    case 2:
      for (Point& point : points) point.color += glm::u16vec3(100, 7, 1);
      return;
    case 3:  // across leaves
      for (Point& point : points)
        if (near(point)) point.position += 0.05f * point.normal;
      return;
    case 4: {  // more surfels
      const std::size_t count = points.size();
      for (std::size_t i = 0; i < count; ++i)
        if (near(points[i])) points.push_back({points[i].position * 1.02f, points[i].normal});
      return;
    }
    case 5:
      for (Point& point : points)
        if (near(point)) point.radius *= 1.1f;
      return;
    case 6:
      for (Point& point : points)
        if (near(point)) point.normal = glm::normalize(point.normal + glm::vec3(0.2f, 0.1f, 0.0f));
      return;
    default:
      points[random() % points.size()].position *= 0.999f;
      return;
  }
}

void expect_same(const RecordedStrips& updated, const Frame& frame) {
  const SurfelStrips expected = make_strips(frame.surfels(), frame.attributes);
  ASSERT_EQ(updated.strips.indices, expected.indices);
  ASSERT_EQ(updated.strips.nodes, expected.nodes);
}

TEST(StripUpdate, is_the_same_as_making_all_again_whatever_changed) {
  for (const bool lines : {false, true}) {
    std::mt19937 random(lines ? 8 : 7);
    std::vector<Point> points = body();
    std::shared_ptr<const StripRecord> record;
    for (int step = 0; step < 60; ++step) {
      SCOPED_TRACE(step);
      Frame frame = frame_of(points);
      frame.lines = lines;
      const RecordedStrips updated = update_strips(frame.surfels(), frame.attributes, record);
      expect_same(updated, frame);
      if (HasFatalFailure()) return;
      // Sometimes the record stays behind, as when frames are prepared out of order.
      if (random() % 4 != 0) record = updated.record;
      change(points, random);
    }
  }
}

TEST(StripUpdate, does_not_depend_on_threads) {
  std::vector<Point> points = body();
  const Frame first = frame_of(points);
  std::mt19937 random(12);
  for (int i = 0; i < 4; ++i) change(points, random);
  const Frame second = frame_of(points);
  for (const Executor& executor : some_executors()) {
    const auto record =
        update_strips(first.surfels(), first.attributes, nullptr, {}, executor).record;
    expect_same(update_strips(second.surfels(), second.attributes, record, {}, executor), second);
  }
}

TEST(StripUpdate, makes_only_patches_around_what_changed) {
  std::vector<Point> points = body();
  const Frame first = frame_of(points);
  const RecordedStrips all = update_strips(first.surfels(), first.attributes, nullptr);
  ASSERT_GT(all.made, 200u);
  EXPECT_EQ(update_strips(first.surfels(), first.attributes, all.record).made, 0u);
  for (Point& point : points) point.color = glm::u16vec3(1, 2, 3);
  const Frame colored = frame_of(points);
  const RecordedStrips recolored = update_strips(colored.surfels(), colored.attributes, all.record);
  EXPECT_EQ(recolored.made, 0u);
  EXPECT_EQ(recolored.strips.nodes[0].color, glm::u16vec3(1, 2, 3));
  points[0].position *= 1.001f;
  const Frame moved = frame_of(points);
  const std::uint32_t few = update_strips(moved.surfels(), moved.attributes, recolored.record).made;
  EXPECT_GT(few, 0u);
  EXPECT_LT(few, all.made / 5);
}

TEST(StripUpdate, makes_all_again_for_another_tree_other_rules_and_other_signs) {
  const std::vector<Point> points = body();
  const Frame first = frame_of(points);
  const auto record = update_strips(first.surfels(), first.attributes, nullptr).record;
  const Frame deeper = frame_of(points, 8);
  expect_same(update_strips(deeper.surfels(), deeper.attributes, record), deeper);
  Cube elsewhere = kCube;
  elsewhere.origin.x -= 0.01;
  const Frame other_cube = frame_of(points, 7, elsewhere);
  expect_same(update_strips(other_cube.surfels(), other_cube.attributes, record), other_cube);
  Frame lines = first;
  lines.lines = true;
  expect_same(update_strips(lines.surfels(), lines.attributes, record), lines);
  StripRules rules;
  rules.patch.most = 50;
  const auto updated = update_strips(first.surfels(), first.attributes, record, rules);
  EXPECT_EQ(updated.strips, make_strips(first.surfels(), first.attributes, rules));
}

TEST(StripUpdate, bears_frames_without_surfels) {
  const Frame some = frame_of(body()), none = frame_of({});
  auto made = update_strips(none.surfels(), none.attributes, nullptr);
  EXPECT_TRUE(made.strips.empty());
  made = update_strips(some.surfels(), some.attributes, made.record);
  expect_same(made, some);
  made = update_strips(none.surfels(), none.attributes, made.record);
  EXPECT_TRUE(made.strips.empty());
}

}  // namespace
}  // namespace pointreel::strip_update_test
