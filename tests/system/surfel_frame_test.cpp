#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/stability/surfel_frames.h"

namespace pointreel::surfel_frame_test {
namespace {

std::vector<glm::vec3> normals() {
  std::vector<glm::vec3> all;
  for (const float y : {1.0f, -1.0f}) {
    all.push_back({0.0f, y, 0.0f});
    all.push_back({0.0f, std::nextafter(y, 0.0f), 0.0f});
    // One ulp beside the pole, the smallest numbers beside it, and both sides of the tolerance of
    // surfel.glsl.
    for (const float beside :
         {std::nextafter(0.0f, 1.0f), 1.2e-38f, 6e-8f, 0.99e-6f, 1.01e-6f, 1e-4f}) {
      for (const float sign : {1.0f, -1.0f}) {
        all.push_back(glm::normalize(glm::vec3(sign * beside, y, 0.0f)));
        all.push_back(glm::normalize(glm::vec3(0.0f, y, sign * beside)));
        all.push_back(glm::normalize(glm::vec3(sign * beside, y, beside)));
      }
    }
  }
  for (const float s : {1.0f, -1.0f}) {
    all.push_back({s, 0.0f, 0.0f});
    all.push_back({0.0f, 0.0f, s});
  }
  std::mt19937 random(11);
  std::normal_distribution<float> normal;
  for (int i = 0; i < 20000; ++i) {
    all.push_back(glm::normalize(glm::vec3(normal(random), normal(random), normal(random))));
  }
  return all;
}

TEST(SurfelFrame, is_orthonormal_and_right_handed_for_every_normal) {
  const std::vector<glm::vec3> all = normals();
  const auto frames = surfel_frames(all);
  ASSERT_TRUE(frames) << frames.error().message;
  ASSERT_EQ(frames->size(), all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const glm::vec3& n = all[i];
    const glm::dvec3 u((*frames)[i].u), v((*frames)[i].v), w(n);
    ASSERT_NEAR(glm::length(u), 1.0, 1e-6) << n.x << " " << n.y << " " << n.z;
    ASSERT_NEAR(glm::length(v), 1.0, 1e-6) << n.x << " " << n.y << " " << n.z;
    ASSERT_NEAR(glm::dot(u, v), 0.0, 1e-6);
    ASSERT_NEAR(glm::dot(u, w), 0.0, 1e-6);
    ASSERT_NEAR(glm::dot(v, w), 0.0, 1e-6);
    ASSERT_LT(glm::length(glm::cross(u, v) - w), 2e-6) << "the frame is left-handed";
  }
}

}  // namespace
}  // namespace pointreel::surfel_frame_test
