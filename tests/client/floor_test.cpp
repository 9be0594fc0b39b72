#include "client/render/opengl/floor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "codec/core/build.h"
#include "tests/client/drawing_test.h"
#include "tests/read_alpha.h"

namespace pointreel::floor_test {
namespace {

constexpr glm::ivec2 kSize(320, 240);
const double kAspect = static_cast<double>(kSize.x) / kSize.y;

Box box_of(double edge, const glm::dvec3& middle = glm::dvec3(0.0)) {
  return {middle - 0.5 * edge, middle + 0.5 * edge};
}

Camera camera_of(const FloorGrid& grid, double pitch_by = 0.2) {
  Camera camera;
  camera.up = grid.up;
  camera.frame_bounds(grid.bounds, kAspect);
  camera.orbit(0.4, pitch_by);
  return camera;
}

TEST(FloorGrid, steps_are_round_numbers_in_proportion_to_the_scene) {
  for (const double edge : {1e-6, 0.37, 1.0, 1.9, 2.0, 4.4, 80.0, 12345.0, 3e9}) {
    const double step = floor_step(box_of(edge));
    const double digits = step / std::pow(10.0, std::floor(std::log10(step) + 1e-9));
    EXPECT_LT(std::min({std::abs(digits - 1.0), std::abs(digits - 2.0), std::abs(digits - 5.0)}),
              1e-9)
        << step;
    const double lines = floor_reach(box_of(edge)) / step;
    EXPECT_GE(lines, 6.999);
    EXPECT_LE(lines, 17.6);
  }
  EXPECT_EQ(floor_step(Box{}), floor_step(box_of(1.0)));
  EXPECT_EQ(floor_step({{1, 2, 3}, {1, 2, 3}}), floor_step(box_of(1.0)));
}

TEST(FloorGrid, the_floor_is_on_the_side_that_is_down) {
  const Box box{{1, 2, 3}, {4, 5, 6}};
  for (const char letter : {'x', 'y', 'z'}) {
    const int axis = letter - 'x';
    EXPECT_EQ(floor_origin({box, letter})[axis], box.min[axis]);
    EXPECT_EQ(floor_origin({box, Up(letter, true)})[axis], box.max[axis]);
    const FloorGrid grid{box, Up(letter, true)};
    for (const FloorLine& line : floor_lines(grid, camera_of(grid))) {
      EXPECT_EQ(line.from[axis], 0.0f);
      EXPECT_EQ(line.to[axis], 0.0f);
    }
  }
}

TEST(FloorGrid, lines_lie_below_the_scene_at_multiples_of_the_step_within_a_disc) {
  for (const char up : {'y', 'z'}) {
    for (const glm::dvec3& middle : {glm::dvec3(0.3, 1.2, -0.7), glm::dvec3(4e6, -7e6, 2e5)}) {
      const FloorGrid grid{box_of(2.0, middle), up};
      const glm::dvec3 origin = floor_origin(grid);
      EXPECT_EQ(up == 'z' ? origin.z : origin.y, (up == 'z' ? middle.z : middle.y) - 1.0);
      const double step = floor_step(grid.bounds), reach = floor_reach(grid.bounds);
      Camera camera = camera_of(grid);
      camera.zoom(4.0);  // all of it is in front of the eye
      const auto lines = floor_lines(grid, camera);
      EXPECT_NEAR(static_cast<double>(lines.size()), 4.0 * reach / step, 4.0);
      int strong = 0;
      for (const FloorLine& line : lines) {
        const glm::vec3 along = glm::normalize(line.to - line.from);
        const int axis = std::abs(along.x) > 0.5f ? (up == 'z' ? 1 : 2) : 0;
        EXPECT_NEAR(along[axis], 0.0f, 1e-6f);
        const double world = origin[axis] + line.from[axis];
        EXPECT_NEAR(std::remainder(world, step), 0.0, 1e-6);
        EXPECT_EQ(up == 'z' ? line.from.z : line.from.y, 0.0f);
        EXPECT_NEAR(glm::length(line.from), reach, 1e-5);
        EXPECT_NEAR(glm::length(line.to), reach, 1e-5);
        if (line.strength < 1.0f) continue;
        ++strong;
        EXPECT_NEAR(std::remainder(world, line.step), 0.0, 1e-6);
        EXPECT_GT(line.step, 1.5 * step);
      }
      EXPECT_GT(strong, 2);
      EXPECT_LT(strong, static_cast<int>(lines.size()) * 2 / 3);
    }
  }
}

TEST(FloorGrid, lines_end_in_front_of_an_eye_among_them) {
  const FloorGrid grid{box_of(2.0), 'y'};
  Camera camera = camera_of(grid);
  camera.fly({0.0, 0.0, camera.distance}, 0.0, 0.0);
  const auto lines = floor_lines(grid, camera);
  ASSERT_GT(lines.size(), 10u);
  int cut = 0;
  for (const FloorLine& line : lines) {
    for (const glm::vec3& end : {line.from, line.to}) {
      const glm::dvec3 world = floor_origin(grid) + glm::dvec3(end);
      const double depth = glm::dot(camera.eye() - world, camera.axes()[2]);
      EXPECT_GE(depth, 0.999 * camera.near_plane() - 1e-6);
      cut += depth < 1.1 * camera.near_plane() ? 1 : 0;
    }
  }
  EXPECT_GT(cut, 5);
  // No line is in front of an eye that looks away from the floor.
  camera.fly({0.0, 100.0, 0.0}, 0.0, -3.0);
  EXPECT_TRUE(floor_lines(grid, camera).empty());
}

class FloorTest : public DrawingTest {
 protected:
  /// A closed ball of surfels on the floor.
  static std::shared_ptr<SceneFrame> ball(const glm::dvec3& middle) {
    auto frame = std::make_shared<SceneFrame>();
    PointCloud& cloud = frame->cloud;
    cloud.origin = middle;
    for (int i = 0; i < 3000; ++i) {
      const float z = 1.0f - 2.0f * (static_cast<float>(i) + 0.5f) / 3000.0f;
      const float turn = 2.399963f * static_cast<float>(i), r = std::sqrt(1.0f - z * z);
      const glm::vec3 n(r * std::cos(turn), r * std::sin(turn), z);
      cloud.positions.push_back(n);
      cloud.normals.push_back(n);
      cloud.colors.push_back(glm::u16vec3(0xc000, 0x8000, 0x2000));
      cloud.radii.push_back(0.06f);
    }
    const SortedPoints sorted = sort_points(cloud, {middle - 1.5, 3.0});
    frame->svo = build_svo(sorted, 5);
    frame->attributes = mean_attributes(frame->svo, cloud, sorted);
    return frame;
  }

  static std::size_t changed(const Image& a, const Image& b, const std::vector<std::uint8_t>& alpha,
                             bool covered) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < alpha.size(); ++i)
      count += (alpha[i] > 0) == covered && a.pixels[i] != b.pixels[i] ? 1u : 0u;
    return count;
  }
};

INSTANTIATE_TEST_SUITE_P(, FloorTest, kBothRenderers, renderer_name);

TEST_P(FloorTest, is_hidden_by_the_scene_from_above_and_hides_it_from_below) {
  std::vector<DrawOptions> ways;
  for (int i = 0; i < static_cast<int>(kEnumNames<Splatting>.size()); ++i)
    ways.emplace_back().splatting = static_cast<Splatting>(i);
  ways.emplace_back().mode = DrawMode::voxel;
  ways.emplace_back().mode = DrawMode::point;
  ways.emplace_back().edl = 1.0f;
  for (const char up : {'y', 'z'}) {
    const FloorGrid grid{box_of(2.0), up};
    for (const DrawOptions& way : ways) {
      for (const double pitch_by : {0.2, -0.6}) {
        const Camera camera = camera_of(grid, pitch_by);
        DrawOptions with = way;
        with.floor = grid;
        const Image without = draw(ball(glm::dvec3(0.0)), camera, kSize, way);
        const auto alpha = read_alpha(*renderer_);
        const Image floor = draw(ball(glm::dvec3(0.0)), camera, kSize, with);
        ASSERT_FALSE(alpha.empty());
        EXPECT_GT(changed(without, floor, alpha, false), 1000u);
        // Blended splats let the floor show through at their rims.
        const bool solid = way.mode != DrawMode::surfel || way.splatting == Splatting::normalized;
        if (pitch_by < 0.0) {
          EXPECT_GT(changed(without, floor, alpha, true), 200u);
        } else if (solid) {
          EXPECT_EQ(changed(without, floor, alpha, true), 0u);
        }
        EXPECT_EQ(read_alpha(*renderer_), alpha);
      }
    }
  }
}

TEST_P(FloorTest, contrasts_with_dark_and_with_light_backgrounds) {
  const FloorGrid grid{box_of(2.0), 'y'};
  for (const float background : {0.0f, 0.12f, 0.9f, 1.0f}) {
    DrawOptions options;
    options.background = glm::vec3(background);
    options.floor = grid;
    const Image image = draw(Scene{}, camera_of(grid), kSize, options);
    const auto own = static_cast<int>(std::lround(255.0f * background));
    int seen = 0;
    for (const glm::u8vec3& pixel : image.pixels) {
      EXPECT_EQ(pixel.x < own, background > 0.5f && pixel.x != own);
      seen += std::abs(pixel.x - own) > 12 ? 1 : 0;
    }
    EXPECT_GT(seen, 1000);
    EXPECT_LT(seen, kSize.x * kSize.y / 4);
  }
}

TEST_P(FloorTest, looks_the_same_far_from_the_origin_of_the_world) {
  const FloorGrid here{box_of(2.0), 'z'};
  const glm::dvec3 offset = 1e7 * floor_step(here.bounds) * glm::dvec3(1.0, -2.0, 1.0);
  const FloorGrid there{box_of(2.0, offset), 'z'};
  const Camera camera = camera_of(here);
  Camera far = camera;
  far.target += offset;
  DrawOptions options;
  options.floor = here;
  const Image near_picture = draw(Scene{}, camera, kSize, options);
  options.floor = there;
  const Image far_picture = draw(Scene{}, far, kSize, options);
  int largest = 0;
  for (std::size_t i = 0; i < near_picture.pixels.size(); ++i)
    largest = std::max(largest, std::abs(near_picture.pixels[i].x - far_picture.pixels[i].x));
  EXPECT_LE(largest, 3);
}

TEST_P(FloorTest, leaves_nothing_behind_when_it_is_switched_off) {
  const FloorGrid grid{box_of(2.0), 'y'};
  const Camera camera = camera_of(grid);
  DrawOptions options;
  const Image before = draw(ball(glm::dvec3(0.0)), camera, kSize, options);
  options.floor = grid;
  draw(ball(glm::dvec3(0.0)), camera, kSize, options);
  options.floor.reset();
  EXPECT_EQ(draw(ball(glm::dvec3(0.0)), camera, kSize, options).pixels, before.pixels);
}

}  // namespace
}  // namespace pointreel::floor_test
