#include "client/render/opengl/outlines.h"

#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "client/render/supersampling.h"
#include "tests/client/drawing_test.h"

namespace pointreel::outlines_test {
namespace {

constexpr glm::ivec2 kSize(160, 120);

/// A white disc, and a slanted line one pixel wide beside it.
std::shared_ptr<const SceneFrame> disc_and_line() {
  auto frame = std::make_shared<SceneFrame>();
  PointCloud& cloud = frame->cloud;
  const auto add = [&](const glm::vec3& at, float radius) {
    cloud.positions.push_back(at);
    cloud.normals.emplace_back(0.0f, 0.0f, 1.0f);
    cloud.colors.emplace_back(0xffff);
    cloud.radii.push_back(radius);
  };
  for (int i = 0; i < 2000; ++i) {
    const float r = 0.8f * std::sqrt(static_cast<float>(i) / 2000.0f),
                a = 2.4f * static_cast<float>(i);
    add({r * std::cos(a) - 0.4f, r * std::sin(a), 0.0f}, 0.03f);
  }
  for (int i = 0; i < 400; ++i) {
    const float t = static_cast<float>(i) / 400.0f;
    add({1.0f + 0.3f * t, 1.6f * t - 0.8f, 0.0f}, 0.006f);
  }
  return frame;
}

class OutlinesTest : public DrawingTest {
 protected:
  Image picture(bool smooth, int scale = 1) {
    DrawOptions options;
    options.smooth_outlines = smooth;
    options.lighting = false;
    Camera camera;
    camera.distance = 4.0;
    return draw(disc_and_line(), camera, kSize * scale, options);
  }
};

double difference(const Image& a, const Image& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const glm::dvec3 d = glm::dvec3(a.pixels[i]) - glm::dvec3(b.pixels[i]);
    sum += glm::dot(d, d);
  }
  return std::sqrt(sum / static_cast<double>(a.pixels.size()));
}

INSTANTIATE_TEST_SUITE_P(, OutlinesTest, kBothRenderers, renderer_name);

TEST_P(OutlinesTest, come_closer_to_a_picture_with_many_samples) {
  const Image many = average_squares(picture(false, 8), 8);
  const double hard = difference(picture(false), many), smooth = difference(picture(true), many);
  EXPECT_LT(smooth, 0.65 * hard) << hard;
}

TEST_P(OutlinesTest, change_no_pixel_that_has_no_outline_beside_it) {
  const Image hard = picture(false), smooth = picture(true);
  const glm::u8vec3 background = hard.at(0, 0);
  int changed = 0;
  for (int y = 1; y + 1 < kSize.y; ++y) {
    for (int x = 1; x + 1 < kSize.x; ++x) {
      const bool drawn = hard.at(x, y) != background;
      bool outline = false;
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i)
          outline = outline || (hard.at(x + i, y + j) != background) != drawn;
      if (!outline) {
        EXPECT_EQ(smooth.at(x, y), hard.at(x, y)) << x << ' ' << y;
      }
      changed += smooth.at(x, y) != hard.at(x, y) ? 1 : 0;
    }
  }
  EXPECT_GT(changed, 50);
}

TEST_P(OutlinesTest, keep_thin_lines) {
  const Image hard = picture(false), smooth = picture(true);
  const glm::u8vec3 background = hard.at(0, 0);
  double before = 0.0, after = 0.0;
  for (int y = 0; y < kSize.y; ++y) {
    for (int x = 120; x < kSize.x; ++x) {
      before += hard.at(x, y).r - background.r;
      after += smooth.at(x, y).r - background.r;
    }
  }
  EXPECT_GT(before, 1000.0);
  EXPECT_GT(after, 0.5 * before);
}

TEST_P(OutlinesTest, are_smoothed_whatever_is_drawn) {
  DrawOptions options;
  options.mode = DrawMode::point;
  options.point_size = 8.0f;
  Camera camera;
  camera.distance = 4.0;
  const Image hard = draw(disc_and_line(), camera, kSize, options);
  options.smooth_outlines = true;
  EXPECT_GT(difference(draw(disc_and_line(), camera, kSize, options), hard), 0.1);
}

}  // namespace
}  // namespace pointreel::outlines_test
