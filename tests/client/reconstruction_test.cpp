#include "client/render/opengl/reconstruction.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/client/cloud_frame.h"
#include "tests/client/drawing_test.h"

namespace pointreel::reconstruction_test {
namespace {

constexpr glm::u16vec3 kRed(0xffff, 0, 0), kGreen(0, 0xffff, 0), kBlue(0, 0, 0xffff);
constexpr glm::u8vec3 kRed8(255, 0, 0), kGreen8(0, 255, 0), kBackground(51, 102, 153);
constexpr glm::ivec2 kSize(241, 181);

/// Adds the points of a sphere, evenly spaced on a spiral, that `keep` selects by their direction
/// from its centre.
void add_sphere(PointCloud& cloud, const glm::vec3& center, float radius, const glm::u16vec3& color,
                const std::function<bool(const glm::vec3&)>& keep) {
  constexpr int kPoints = 3000;
  for (int i = 0; i < kPoints; ++i) {
    const double y = 1.0 - 2.0 * (i + 0.5) / kPoints, r = std::sqrt(1.0 - y * y);
    const double turn = std::numbers::pi * (3.0 - std::sqrt(5.0)) * i;
    const glm::vec3 n(static_cast<float>(r * std::cos(turn)), static_cast<float>(y),
                      static_cast<float>(r * std::sin(turn)));
    if (!keep(n)) continue;
    cloud.positions.push_back(center + radius * n);
    cloud.normals.push_back(n);
    cloud.colors.push_back(color);
    cloud.radii.push_back(radius * 0.045f);
  }
}
bool all(const glm::vec3&) { return true; }
/// Omits a patch that faces the eye.
bool but_the_front(const glm::vec3& n) { return n.z < 0.9f; }

bool near(const glm::u8vec3& a, const glm::u8vec3& b) {
  const glm::ivec3 apart = glm::abs(glm::ivec3(a) - glm::ivec3(b));
  return std::max({apart.x, apart.y, apart.z}) <= 2;
}

class ReconstructionTest : public DrawingTest {
 protected:
  ReconstructionTest() {
    options_.lighting = false;
    options_.background = glm::vec3(0.2f, 0.4f, 0.6f);
    camera_.distance = 4.0;
  }

  Image picture(const std::shared_ptr<const SceneFrame>& frame) {
    return draw(frame, camera_, kSize, options_);
  }
  Image picture(PointCloud cloud) { return picture(cloud_frame(std::move(cloud))); }

  /// The pixel at the middle of the picture, or a share of its height to the right of it.
  static const glm::u8vec3& middle(const Image& image, double right = 0.0) {
    return image.at(kSize.x / 2 + static_cast<int>(right * kSize.y), kSize.y / 2);
  }

  DrawOptions options_;
  Camera camera_;
};

INSTANTIATE_TEST_SUITE_P(, ReconstructionTest, kBothRenderers, renderer_name);

TEST_P(ReconstructionTest, a_hole_in_a_closed_surface_is_filled_with_the_surrounding_colours) {
  PointCloud cloud;
  add_sphere(cloud, glm::vec3(0.0f), 1.0f, kRed, but_the_front);
  const Image image = picture(cloud);
  // The rim of the hole is 0.44 from the middle.
  const int rim = static_cast<int>(0.44 / 3.0 / std::tan(0.5 * camera_.fov_y) * 0.5 * kSize.y);
  for (int x = -rim; x <= rim; ++x) {
    ASSERT_TRUE(near(image.at(kSize.x / 2 + x, kSize.y / 2), kRed8)) << x;
    ASSERT_TRUE(near(image.at(kSize.x / 2, kSize.y / 2 + x), kRed8)) << x;
  }
}

TEST_P(ReconstructionTest, a_hole_stays_if_filling_is_off) {
  PointCloud cloud;
  add_sphere(cloud, glm::vec3(0.0f), 1.0f, kRed, but_the_front);
  options_.fill_holes = false;
  EXPECT_EQ(middle(picture(cloud)), kBackground);
}

TEST_P(ReconstructionTest, objects_behind_a_hole_do_not_show_through_it) {
  PointCloud cloud;
  add_sphere(cloud, glm::vec3(0.0f), 0.5f, kRed, but_the_front);
  add_sphere(cloud, {0.0f, 0.0f, -3.0f}, 1.0f, kGreen, all);
  const Image image = picture(cloud);
  EXPECT_GT(middle(image).r, middle(image).g);  // colours beside the hole count as well
  options_.fill_holes = false;
  EXPECT_TRUE(near(middle(picture(cloud)), kGreen8));
}

TEST_P(ReconstructionTest, an_opening_between_surfaces_stays_open) {
  PointCloud cloud;
  for (const float x : {-0.54f, 0.54f}) add_sphere(cloud, {x, 0.0f, 0.0f}, 0.5f, kRed, all);
  const Image image = picture(cloud);
  EXPECT_EQ(middle(image), kBackground);
  options_.fill_holes = false;
  const Image without = picture(cloud);
  const auto covered = [](const Image& of) {
    return std::count_if(of.pixels.begin(), of.pixels.end(),
                         [](const glm::u8vec3& p) { return p != kBackground; });
  };
  // The silhouette is no wider than before, or hardly so.
  EXPECT_LE(static_cast<double>(covered(image)), 1.02 * static_cast<double>(covered(without)));
}

TEST_P(ReconstructionTest, a_one_sided_surface_is_invisible_from_behind) {
  PointCloud cloud;
  for (int y = -20; y <= 20; ++y) {
    for (int x = -20; x <= 20; ++x) {
      cloud.positions.push_back({0.02f * static_cast<float>(x), 0.02f * static_cast<float>(y), 0});
      cloud.normals.push_back({0.0f, 0.0f, -1.0f});
      cloud.colors.push_back(kBlue);
      cloud.radii.push_back(0.02f);
    }
  }
  for (const glm::u8vec3& pixel : picture(cloud).pixels) ASSERT_EQ(pixel, kBackground);
  // Nor are they with something of another colour that is far away in the picture.
  add_sphere(cloud, {1.6f, 0.0f, 0.0f}, 0.1f, kRed, all);
  const Image image = picture(cloud);
  EXPECT_EQ(middle(image), kBackground);
  EXPECT_EQ(middle(image, -0.1), kBackground);
}

TEST_P(ReconstructionTest, a_side_that_is_open_is_no_hole) {
  // A capture from one side, with a few points that face the other way.
  PointCloud cloud;
  add_sphere(cloud, glm::vec3(0.0f), 1.0f, kRed, [](const glm::vec3& p) { return p.z < 0.0f; });
  add_sphere(cloud, {0.1f, 0.05f, 0.0f}, 0.05f, kGreen, all);
  const Image image = picture(cloud);
  int filled = 0;
  for (const glm::u8vec3& pixel : image.pixels) filled += pixel != kBackground ? 1 : 0;
  EXPECT_LT(filled, 0.03 * static_cast<double>(image.pixels.size()));
  EXPECT_EQ(middle(image, -0.15), kBackground);
}

TEST_P(ReconstructionTest, a_gap_between_surfels_is_closed_even_without_a_back_side) {
  // A sheet without a back, of which one surfel is missing.
  PointCloud cloud;
  for (int y = -20; y <= 20; ++y) {
    for (int x = -20; x <= 20; ++x) {
      if (x == 0 && y == 0) continue;
      cloud.positions.push_back({0.05f * static_cast<float>(x), 0.05f * static_cast<float>(y), 0});
      cloud.normals.push_back({0.0f, 0.0f, 1.0f});
      cloud.colors.push_back(kGreen);
      cloud.radii.push_back(0.03f);
    }
  }
  const auto frame = cloud_frame(cloud);
  const Image image = picture(frame);
  EXPECT_TRUE(near(middle(image), kGreen8));
  // Its outline does not move.
  options_.fill_holes = false;
  const Image without = picture(frame);
  EXPECT_EQ(middle(without), kBackground);
  for (int x = 0; x < kSize.x / 3; ++x) {
    EXPECT_EQ(image.at(x, kSize.y / 2) == kBackground, without.at(x, kSize.y / 2) == kBackground);
  }
}

TEST_P(ReconstructionTest, an_outline_that_leaves_the_picture_does_not_move) {
  PointCloud cloud;
  add_sphere(cloud, glm::vec3(0.0f), 1.0f, kRed, all);
  const auto frame = cloud_frame(cloud);
  camera_.distance = 2.2;
  for (int i = 0; i < 12; ++i) {
    camera_.target = glm::dvec3(0.06 * i, 0.05 * i, 0.0);
    options_.fill_holes = true;
    const Image filled = picture(frame);
    options_.fill_holes = false;
    const Image without = picture(frame);
    int moved = 0;
    for (int y = 0; y < kSize.y; ++y) {
      for (int x = 0; x < kSize.x; ++x) {
        moved += (filled.at(x, y) == kBackground) != (without.at(x, y) == kBackground) ? 1 : 0;
      }
    }
    EXPECT_LE(moved, 20) << i << ", notches between discs";
  }
}

TEST_P(ReconstructionTest, an_outline_does_not_move_where_other_surfels_are_divided) {
  PointCloud cloud;
  add_sphere(cloud, {-0.7f, 0.0f, 0.0f}, 1.0f, kRed, all);
  // A board, whose back is as wide as its front.
  for (const float side : {-1.0f, 1.0f}) {
    for (int i = 0; i < 41 * 41; ++i) {
      const float x = 0.016f * static_cast<float>(i % 41 - 20);
      const float y = 0.016f * static_cast<float>(i / 41 - 20);
      cloud.positions.emplace_back(1.0f + x, y, 0.02f * side);
      cloud.normals.emplace_back(0.0f, 0.0f, side);
      cloud.colors.push_back(kGreen);
      cloud.radii.push_back(0.015f);
    }
  }
  const auto frame = cloud_frame(cloud);
  const auto covered = [&](bool refine) {
    options_.refine = refine;
    const Image image = draw(frame, camera_, {960, 720}, options_);
    return static_cast<double>(std::ranges::count_if(
        image.pixels, [](const glm::u8vec3& p) { return p.g > 128 && p.r < 128 && p.b < 128; }));
  };
  const double before = covered(false);
  ASSERT_GT(before, 10'000.0);
  EXPECT_NEAR(covered(true), before, 0.01 * before) << "surfels of the board look small";
}

TEST_P(ReconstructionTest, filling_does_not_depend_on_earlier_pictures) {
  PointCloud holed, other;
  add_sphere(holed, {0.2f, 0.1f, 0.0f}, 0.4f, kRed, but_the_front);
  add_sphere(other, {-0.5f, -0.2f, 0.0f}, 0.8f, kGreen, but_the_front);
  const auto frame = cloud_frame(holed);
  const Image first = picture(frame);
  picture(cloud_frame(other));
  const Image again = picture(frame);
  EXPECT_TRUE(first.pixels == again.pixels);
  EXPECT_TRUE(picture(frame).pixels == again.pixels);
}

TEST_P(ReconstructionTest, every_method_of_instancing_is_filled_in_the_same_way) {
  PointCloud cloud;
  add_sphere(cloud, glm::vec3(0.0f), 1.0f, kRed, but_the_front);
  const auto frame = cloud_frame(cloud);
  for (const Instancing instancing :
       {Instancing::geometry, Instancing::uniform, Instancing::texture, Instancing::attribute}) {
    options_.instancing = instancing;
    EXPECT_TRUE(near(middle(picture(frame)), kRed8)) << name(instancing);
  }
}

}  // namespace
}  // namespace pointreel::reconstruction_test
