#include "client/render/supersampling.h"

#include <gtest/gtest.h>

namespace pointreel::supersampling_test {
namespace {

TEST(Supersampling, averages_squares_in_linear_light) {
  // Four blocks of 2 x 2 pixels: black; half white and half black; one quarter red; a single
  // colour.
  const glm::u8vec3 black(0), white(255), red(255, 0, 0), some(10, 120, 250);
  const Image image{4,
                    4,
                    {black, black, white, black, black, black, black, white,  //
                     red, black, some, some, black, black, some, some}};
  const Image small = average_squares(image, 2);
  ASSERT_EQ(small.width, 2);
  ASSERT_EQ(small.height, 2);
  EXPECT_EQ(small.at(0, 0), black);
  EXPECT_EQ(small.at(1, 0), glm::u8vec3(188));        // 0.5 in sRGB
  EXPECT_EQ(small.at(0, 1), glm::u8vec3(137, 0, 0));  // 0.25 in sRGB
  EXPECT_EQ(small.at(1, 1), some);
}

TEST(Supersampling, preserves_every_uniform_colour) {
  Image image{3 * 256, 3, {}};
  for (int i = 0; i < image.width * image.height; ++i)
    image.pixels.emplace_back(static_cast<std::uint8_t>(i % image.width / 3));
  const Image small = average_squares(image, 3);
  for (int i = 0; i < 256; ++i) EXPECT_EQ(small.at(i, 0).x, i);
  EXPECT_TRUE(average_squares(image, 1).pixels == image.pixels);
}

}  // namespace
}  // namespace pointreel::supersampling_test
