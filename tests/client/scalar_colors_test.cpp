#include "client/scene/scalar_colors.h"

#include <cmath>
#include <limits>
#include <memory>
#include <set>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/render/legend_picture.h"
#include "client/scene/legend.h"
#include "codec/core/build.h"

namespace pointreel::scalar_colors_test {
namespace {

using testing::ElementsAre;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

glm::u16vec3 wide(const glm::u8vec3& color) { return glm::u16vec3(color) * std::uint16_t{257}; }

/// Relative luminance (IEC 61966-2-1).
double luminance(const glm::u8vec3& color) {
  const auto linear = [](double v) {
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(color.r / 255.0) + 0.7152 * linear(color.g / 255.0) +
         0.0722 * linear(color.b / 255.0);
}

TEST(RampColor, gets_lighter_by_equal_steps_from_one_end_to_the_other) {
  // CIE lightness: 116 Y^(1/3) - 16.
  const auto lightness = [](double share) {
    return 116.0 * std::cbrt(luminance(ramp_color(share))) - 16.0;
  };
  const double step = (lightness(1.0) - lightness(0.0)) / 10.0;
  EXPECT_GT(step, 7.0);
  for (int i = 0; i < 10; ++i)
    EXPECT_NEAR(lightness((i + 1) / 10.0) - lightness(i / 10.0), step, 0.35 * step) << i;
  EXPECT_EQ(ramp_color(-3.0), ramp_color(0.0));
  EXPECT_EQ(ramp_color(7.0), ramp_color(1.0));
}

TEST(LabelColor, tells_labels_apart) {
  std::set<std::tuple<int, int, int>> seen;
  for (int label = 0; label < 12; ++label) {
    const glm::u8vec3 color = label_color(label);
    EXPECT_TRUE(seen.emplace(color.r, color.g, color.b).second) << label;
    EXPECT_EQ(label_color(label + 12), color);
    EXPECT_EQ(label_color(label - 12), color);
    EXPECT_GT(glm::length(glm::vec3(color) - glm::vec3(label_color(label + 1))), 60.0f) << label;
  }
}

TEST(ScalarColors, stand_for_the_place_in_the_range) {
  const ShownScalar shown{{"heat", 10.0, 20.0, false}, {}};
  EXPECT_THAT(scalar_colors(shown, std::vector<float>{10, 15, 20, 30, -5, kNan}),
              ElementsAre(wide(ramp_color(0)), wide(ramp_color(0.5)), wide(ramp_color(1)),
                          wide(ramp_color(1)), wide(ramp_color(0)), wide(kUnknownColor)));
  const ShownScalar constant{{"heat", 3.0, 3.0, false}, {}};
  EXPECT_THAT(scalar_colors(constant, std::vector<float>{3}), ElementsAre(wide(ramp_color(0.5))));
}

TEST(ScalarColors, of_labels_do_not_depend_on_the_range) {
  const ShownScalar shown{{"class", 2.0, 6.0, true}, {2, 6}};
  EXPECT_THAT(scalar_colors(shown, std::vector<float>{6, 2, kNan}),
              ElementsAre(wide(label_color(6)), wide(label_color(2)), wide(kUnknownColor)));
}

/// A tree with a root and three leaves.
Svo three_leaves() {
  PointCloud cloud;
  cloud.positions = {{0.1f, 0.1f, 0.1f}, {0.9f, 0.1f, 0.1f}, {0.1f, 0.9f, 0.1f}};
  return build_svo(sort_points(cloud, {glm::dvec3(0.0), 1.0}, 1), 1);
}

TEST(ScalarNodeColors, are_means_of_values_but_never_of_labels) {
  const ShownScalar heat{{"heat", 0.0, 1.0, false}, {}};
  const auto mixed = scalar_node_colors(heat, three_leaves(), std::vector<float>{0, 0, 1});
  ASSERT_EQ(mixed.size(), 4u);
  EXPECT_EQ(mixed[1], wide(ramp_color(0)));
  EXPECT_EQ(mixed[3], wide(ramp_color(1)));
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(mixed[0][i], (2.0 * mixed[1][i] + mixed[3][i]) / 3.0, 1.0);

  const ShownScalar labels{{"class", 1.0, 3.0, true}, {1, 3}};
  const auto most = scalar_node_colors(labels, three_leaves(), std::vector<float>{3, 1, 1});
  EXPECT_EQ(most[0], wide(label_color(1)));
  EXPECT_EQ(most[1], wide(label_color(3)));
}

Scene scene_of(const ShownScalar& shown) {
  auto frame = std::make_shared<SceneFrame>();
  frame->scalar = shown;
  return {{nullptr, {}}, {std::make_shared<SceneFrame>(), {}}, {frame, {}}};
}

TEST(Legend, names_the_field_and_the_ends_of_its_range) {
  const auto legend = legend_of(scene_of({{"heat", -1.5, 36.66666, false}, {}}));
  ASSERT_TRUE(legend);
  EXPECT_EQ(*legend, (Legend{"heat", "-1.5", "36.67", {}}));
  EXPECT_FALSE(legend_of({}));
  EXPECT_FALSE(legend_of({{std::make_shared<SceneFrame>(), {}}}));
}

TEST(Legend, lists_labels_with_their_colours) {
  const auto legend = legend_of(scene_of({{"class", 1, 6, true}, {1, 6}}));
  ASSERT_TRUE(legend);
  EXPECT_EQ(*legend, (Legend{"class", "", "", {{label_color(1), "1"}, {label_color(6), "6"}}}));
}

Image grey(int width, int height) {
  Image image{width, height, {}};
  image.pixels.assign(static_cast<std::size_t>(width * height), glm::u8vec3(77));
  return image;
}

std::size_t count(const Image& image, const glm::u8vec3& color) {
  return static_cast<std::size_t>(std::ranges::count(image.pixels, color));
}

TEST(LegendPicture, lies_in_the_lower_left_corner_and_shows_the_ramp) {
  Image image = grey(320, 240);
  draw_legend({"heat", "0", "1", {}}, image);
  EXPECT_GT(count(image, ramp_color(0.0)), 4u);
  EXPECT_GT(count(image, ramp_color(1.0)), 4u);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x)
      if (x < 6 || x >= 160 || y < 180 || y >= 234) {
        ASSERT_EQ(image.at(x, y), glm::u8vec3(77)) << x << ", " << y;
      }
  Image other = grey(320, 240);
  draw_legend({"heat", "0", "2", {}}, other);
  EXPECT_NE(other.pixels, image.pixels) << "the numbers are written";
}

TEST(LegendPicture, grows_with_the_picture_and_is_left_out_of_tiny_ones) {
  Image small = grey(320, 240), large = grey(1920, 1080);
  const Legend legend{"class", "", "", {{label_color(3), "3"}}};
  draw_legend(legend, small);
  draw_legend(legend, large);
  EXPECT_EQ(count(large, label_color(3)), 4 * count(small, label_color(3)));
  Image tiny = grey(60, 30);
  draw_legend(legend, tiny);
  EXPECT_EQ(count(tiny, glm::u8vec3(77)), tiny.pixels.size());
}

TEST(LegendPicture, takes_any_text) {
  Image image = grey(320, 240);
  draw_legend({"W\xc3\xa4rme \xff %s", "", "", {{label_color(1), "1"}}}, image);
  EXPECT_GT(count(image, label_color(1)), 4u);
}

}  // namespace
}  // namespace pointreel::scalar_colors_test
