#include "tests/bench/render/image_error.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace pointreel::bench::image_error_test {
namespace {

Image plain(int width, int height, const glm::u8vec3& color) {
  return {width, height, std::vector<glm::u8vec3>(static_cast<std::size_t>(width * height), color)};
}

Image noise(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Image image = plain(width, height, {});
  for (glm::u8vec3& pixel : image.pixels) {
    for (int c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>(random() & 255);
  }
  return image;
}

TEST(Psnr, follows_from_the_mean_squared_error) {
  const Image a = plain(8, 4, {100, 100, 100}), b = plain(8, 4, {110, 90, 100});
  EXPECT_NEAR(*psnr(a, b), 10.0 * std::log10(255.0 * 255.0 * 3.0 / 200.0), 1e-9);
  EXPECT_FALSE(psnr(a, a).has_value());
}

TEST(Psnr, counts_only_pixels_of_the_mask) {
  const Image a = plain(4, 1, {50, 50, 50});
  Image b = a;
  b.pixels[3] = {70, 70, 70};
  EXPECT_FALSE(psnr(a, b, Mask{1, 1, 1, 0}).has_value());
  EXPECT_NEAR(*psnr(a, b, Mask{0, 0, 0, 255}), 20.0 * std::log10(255.0 / 20.0), 1e-9);
  EXPECT_FALSE(psnr(a, b, Mask{0, 0, 0, 0}).has_value());
}

/// The similarity by its definition, pixel by pixel, in double.
double slow_similarity(const Image& a, const Image& b, int x, int y) {
  const auto luma = [](const glm::u8vec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; };
  const auto each = [&](const auto& visit) {
    for (int v = std::max(y - 5, 0); v <= std::min(y + 5, a.height - 1); ++v) {
      for (int u = std::max(x - 5, 0); u <= std::min(x + 5, a.width - 1); ++u) {
        const double d2 = (u - x) * (u - x) + (v - y) * (v - y);
        visit(std::exp(-0.5 * d2 / (1.5 * 1.5)), luma(a.at(u, v)), luma(b.at(u, v)));
      }
    }
  };
  double weights = 0.0, mean_a = 0.0, mean_b = 0.0, var_a = 0.0, var_b = 0.0, covariance = 0.0;
  each([&](double w, double p, double q) {
    weights += w;
    mean_a += w * p;
    mean_b += w * q;
  });
  mean_a /= weights;
  mean_b /= weights;
  each([&](double w, double p, double q) {
    var_a += w * (p - mean_a) * (p - mean_a) / weights;
    var_b += w * (q - mean_b) * (q - mean_b) / weights;
    covariance += w * (p - mean_a) * (q - mean_b) / weights;
  });
  const double c1 = 2.55 * 2.55, c2 = 7.65 * 7.65;
  return (2 * mean_a * mean_b + c1) * (2 * covariance + c2) /
         ((mean_a * mean_a + mean_b * mean_b + c1) * (var_a + var_b + c2));
}

TEST(Similarity, agrees_with_the_definition_at_every_pixel) {
  const Image a = noise(23, 17, 1);
  Image b = a;
  for (int y = 6; y < 12; ++y) {
    for (int x = 14; x < 23; ++x) {  // up to the edge of the picture
      b.pixels[static_cast<std::size_t>(y * 23 + x)] = {9, 200, 90};
    }
  }
  const Similarity fast(a, b);
  double sum = 0.0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      Mask one(a.pixels.size(), 0);
      one[static_cast<std::size_t>(y * a.width + x)] = 255;
      const double slow = slow_similarity(a, b, x, y);
      EXPECT_NEAR(fast.mean(one), slow, 2e-4) << x << ", " << y;
      sum += slow;
    }
  }
  EXPECT_NEAR(fast.mean(), sum / static_cast<double>(a.pixels.size()), 1e-4);
  EXPECT_LT(fast.mean(), 0.9);
}

TEST(Similarity, is_one_for_equal_pictures) {
  const Image a = noise(20, 20, 2);
  EXPECT_EQ(Similarity(a, a).mean(), 1.0);
}

TEST(Coverage, counts_holes_and_excess_pixels) {
  const Coverage c = compare_coverage(Mask{1, 1, 1, 1, 0, 0, 0, 0}, Mask{1, 1, 1, 0, 1, 1, 0, 0});
  EXPECT_DOUBLE_EQ(c.truth, 0.5);
  EXPECT_DOUBLE_EQ(c.holes, 0.25);
  EXPECT_DOUBLE_EQ(c.dilation, 0.5);
  EXPECT_DOUBLE_EQ(c.iou, 0.5);
}

TEST(Coverage, has_no_error_for_empty_masks) {
  const Coverage c = compare_coverage(Mask{0, 0}, Mask{0, 0});
  EXPECT_EQ(c.holes, 0.0);
  EXPECT_EQ(c.dilation, 0.0);
  EXPECT_EQ(c.iou, 1.0);
}

TEST(Difference, reports_the_largest_channel_and_the_root_mean_square) {
  const Image a = plain(2, 2, {10, 20, 30});
  Image b = a;
  b.pixels[2] = {10, 14, 30};
  EXPECT_EQ(difference(a, b).largest, 6);
  EXPECT_NEAR(difference(a, b).rms, std::sqrt(36.0 / 12.0), 1e-12);
  EXPECT_DOUBLE_EQ(difference(a, b).share, 0.25);
  b.pixels[1] = {11, 20, 30};  // a difference that rounding can cause
  EXPECT_DOUBLE_EQ(difference(a, b).share, 0.25);
  EXPECT_EQ(difference(a, a).largest, 0);
  EXPECT_EQ(difference(a, a).rms, 0.0);
}

}  // namespace
}  // namespace pointreel::bench::image_error_test
