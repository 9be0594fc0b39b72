#include <cmath>
#include <cstddef>
#include <memory>
#include <new>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "tests/client/renderer_test.h"

namespace pointreel::strip_picture_test {
namespace {

/// Strips, as both renderers draw them.
class StripPictureTest : public RendererTest {};
INSTANTIATE_TEST_SUITE_P(, StripPictureTest, kBothRenderers, renderer_name);

/// A square from -0.5 to 0.5, whose points are 0.02 apart, with colours that grow with x.
PointCloud square(const glm::vec3& normal = kFront) {
  PointCloud cloud;
  for (int y = 0; y <= 50; ++y) {
    for (int x = 0; x <= 50; ++x) {
      const glm::vec3 p(0.02f * static_cast<float>(x) - 0.5f, 0.02f * static_cast<float>(y) - 0.5f,
                        0.0f);
      add(cloud, p, normal, glm::u16vec3(static_cast<std::uint16_t>(1310 * x)), 0.02f);
    }
  }
  return cloud;
}

DrawOptions strip_options() { return plain(DrawMode::strip); }

TEST_P(StripPictureTest, covers_a_square_and_nothing_beside_it) {
  const auto frame = strip_frame_of(square());
  const Image image = picture(frame, front_camera(), strip_options());
  const Camera camera = front_camera();
  const glm::ivec2 low = pixel_of(camera, {-0.5, 0.5, 0.0}),
                   high = pixel_of(camera, {0.5, -0.5, 0.0});
  std::size_t wrong = 0;
  for (int y = 0; y < kSize.y; ++y) {
    for (int x = 0; x < kSize.x; ++x) {
      const bool inside = x > low.x && x < high.x && y > low.y && y < high.y;
      const bool outside = x < low.x - 1 || x > high.x + 1 || y < low.y - 1 || y > high.y + 1;
      const bool shown =
          difference(image.pixels[static_cast<std::size_t>(y * kSize.x + x)], kBackground) > 0;
      if ((inside && !shown) || (outside && shown)) ++wrong;
    }
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(stats_.drawn, 2u * 50 * 50);
}

TEST_P(StripPictureTest, interpolates_colours_between_points) {
  // Two colours, far apart; the mean is meant in linear light.
  PointCloud cloud;
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 2; ++x)
      add(cloud, {static_cast<float>(x) - 0.5f, static_cast<float>(y) - 0.5f, 0.0f}, kFront,
          glm::u16vec3(x == 0 ? 0 : 0xffff), 1.0f);
  const auto frame = strip_frame_of(cloud);
  const Image image = picture(frame, front_camera(), strip_options(), {241, 181});
  const glm::u8vec3 middle = image.pixels[90 * 241 + 120];
  EXPECT_LE(difference(middle, glm::u8vec3(188)), 2);
}

TEST_P(StripPictureTest, shows_no_backs) {
  const auto frame = strip_frame_of(square(-kFront));
  for (const bool fill_holes : {true, false}) {
    DrawOptions options = strip_options();
    options.fill_holes = fill_holes;
    const Image image = picture(frame, front_camera(), options);
    EXPECT_EQ(count_near(image, kBackground, 0), image.pixels.size());
  }
}

TEST_P(StripPictureTest, shows_both_sides_if_the_signs_of_normals_are_unknown) {
  const auto frame = strip_frame_of(square(-kFront));
  frame->normals_estimated = true;
  DrawOptions options = strip_options();
  options.lighting = true;
  const Image image = picture(frame, front_camera(), options);
  EXPECT_LT(count_near(image, kBackground, 0), image.pixels.size() - 3000);
  const auto other = strip_frame_of(square());
  other->normals_estimated = true;
  EXPECT_LE(largest_difference(image, picture(other, front_camera(), options)), 1);
}

TEST_P(StripPictureTest, fills_a_hole_in_front_of_a_back_and_only_then) {
  std::mt19937 random(7);
  std::normal_distribution<float> normal;
  PointCloud ball;
  for (int i = 0; i < 20'000; ++i) {
    const glm::vec3 n = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
    if (glm::length(n - kFront) < 0.2f) continue;
    add(ball, n, n, kRed, 0.03f);
  }
  const auto frame = strip_frame_of(ball);
  DrawOptions options = strip_options();
  const glm::ivec2 at = pixel_of(front_camera(), glm::dvec3(0.0, 0.0, 1.0));
  const auto middle = static_cast<std::size_t>(at.y * kSize.x + at.x);
  EXPECT_LE(difference(picture(frame, front_camera(), options).pixels[middle], eight_bits(kRed)),
            3);
  options.fill_holes = false;
  EXPECT_EQ(picture(frame, front_camera(), options).pixels[middle], kBackground);
}

TEST_P(StripPictureTest, draws_patches_as_points_from_far_away) {
  const auto frame = strip_frame_of(square());
  Camera camera = front_camera();
  camera.distance = 150.0;
  const Image image = picture(frame, camera, strip_options());
  EXPECT_GT(stats_.below_pixel, 0u);
  EXPECT_LT(stats_.drawn, 200u);
  EXPECT_LT(count_near(image, kBackground, 0), image.pixels.size());
}

TEST_P(StripPictureTest, draws_several_frames_where_they_are) {
  const auto frame = strip_frame_of(square());
  const Image one =
      draw(Scene{{frame, glm::dvec3(0.7, 0.0, 0.0)}}, front_camera(), kSize, strip_options());
  const Image two = draw(
      Scene{{frame, glm::dvec3(-0.7, 0.0, 0.0)}, {nullptr}, {frame, glm::dvec3(0.7, 0.0, 0.0)}},
      front_camera(), kSize, strip_options());
  std::size_t shown_one = 0, shown_two = 0, lost = 0;
  for (std::size_t i = 0; i < one.pixels.size(); ++i) {
    const bool in_one = one.pixels[i] != kBackground, in_two = two.pixels[i] != kBackground;
    shown_one += in_one ? 1 : 0;
    shown_two += in_two ? 1 : 0;
    lost += in_one && !in_two ? 1 : 0;
  }
  EXPECT_EQ(lost, 0u);
  EXPECT_NEAR(static_cast<double>(shown_two), 2.0 * static_cast<double>(shown_one),
              0.05 * static_cast<double>(shown_one));
}

TEST_P(StripPictureTest, tells_a_frame_from_an_earlier_one_at_the_same_address) {
  alignas(SceneFrame) static std::byte place[sizeof(SceneFrame)];
  const auto placed = [](const std::shared_ptr<SceneFrame>& frame) {
    return std::shared_ptr<SceneFrame>(new (place) SceneFrame(std::move(*frame)),
                                       [](SceneFrame* old) { old->~SceneFrame(); });
  };
  PointCloud half = square();
  half.positions.resize(51 * 20);
  half.colors.resize(51 * 20);
  half.normals.resize(51 * 20);
  half.radii.resize(51 * 20);
  picture(placed(strip_frame_of(half)), front_camera(), strip_options());
  draw(Scene{}, front_camera(), kSize, plain(DrawMode::surfel));  // frees it
  const Image image = picture(placed(strip_frame_of(square())), front_camera(), strip_options());
  const Image right = picture(strip_frame_of(square()), front_camera(), strip_options());
  EXPECT_EQ(largest_difference(image, right), 0);
}

TEST_P(StripPictureTest, shows_the_next_frame_and_not_the_last) {
  const auto first = strip_frame_of(square());
  picture(first, front_camera(), strip_options());
  PointCloud other = square();
  for (auto& color : other.colors) color = kGreen;
  const auto second = strip_frame_of(other);
  const Image image = picture(second, front_camera(), strip_options());
  EXPECT_GT(count_near(image, eight_bits(kGreen)), 1000u);
}

}  // namespace
}  // namespace pointreel::strip_picture_test
