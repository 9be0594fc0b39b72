#include "codec/package/strays.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pointreel::strays_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

PointCloud person(std::size_t points) {
  std::mt19937 random(1);
  std::normal_distribution<float> place;
  PointCloud cloud;
  cloud.origin = {500000, 5400000, 0};
  for (std::size_t i = 0; i < points; ++i)
    cloud.positions.emplace_back(0.2f * place(random), 0.5f * place(random), 0.2f * place(random));
  return cloud;
}

TEST(Strays, are_named_by_index_and_position) {
  PointCloud cloud = person(1000);
  EXPECT_THAT(find_strays(cloud), IsEmpty());
  cloud.positions[400] = {0, 1e6f, 0};
  EXPECT_THAT(find_strays(cloud), ElementsAre(400));
  EXPECT_EQ(strays_text(cloud, {400}, true),
            "point 400 at 500000 6400000 0 lies far from all others");
  cloud.positions[7] = {0, 0, -3000};
  EXPECT_THAT(find_strays(cloud), ElementsAre(7, 400));
  EXPECT_EQ(strays_text(cloud, {7, 400}, false),
            "2 points lie far from all others, such as the point at 500000 5400000 -3000");
}

TEST(Strays, may_be_up_to_a_quarter_of_the_points_and_are_never_most_of_them) {
  PointCloud cloud = person(1000);
  for (std::size_t i = 0; i < 240; ++i) cloud.positions[i] = {1e7f, 0, 0};
  EXPECT_EQ(find_strays(cloud).size(), 240u);
  for (std::size_t i = 0; i < 400; ++i) cloud.positions[i] = {1e7f, 0, 0};
  EXPECT_THAT(find_strays(cloud), IsEmpty()) << "these are another thing";
}

TEST(Strays, are_not_the_ends_of_clouds_that_thin_out) {
  PointCloud cloud;
  float distance = 1e-3f;
  for (int i = 0; i < 2000; ++i) cloud.positions.emplace_back(distance *= 1.02f, 0, 0);
  EXPECT_THAT(find_strays(cloud), IsEmpty());
}

TEST(Strays, need_a_few_points_to_be_far_from) {
  PointCloud cloud;
  EXPECT_THAT(find_strays(cloud), IsEmpty());
  for (int i = 0; i < 7; ++i) cloud.positions.emplace_back(i == 6 ? 1e6f : 1.0f, 0, 0);
  EXPECT_THAT(find_strays(cloud), IsEmpty());
  cloud.positions.assign(100, glm::vec3(1.0f));
  cloud.positions[50] = {1e6f, 0, 0};
  EXPECT_THAT(find_strays(cloud), IsEmpty()) << "nothing tells what is far";
}

}  // namespace
}  // namespace pointreel::strays_test
