#include "client/render/light_probe.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace pointreel::light_probe_test {
namespace {

EnvironmentMap environment(int width, int height, glm::vec3 (*light)(const glm::vec3& direction)) {
  EnvironmentMap map{width, height, {}};
  map.texels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) map.at(x, y) = light(direction_of_texel(map, x, y));
  return map;
}

glm::vec3 returned(const LightProbe& probe, const glm::vec3& n) {
  const auto& c = probe.diffuse;
  return c[0] + c[1] * n.y + c[2] * n.z + c[3] * n.x + c[4] * n.x * n.y + c[5] * n.y * n.z +
         c[6] * (3.0f * n.z * n.z - 1.0f) + c[7] * n.x * n.z + c[8] * (n.x * n.x - n.y * n.y);
}

/// The light that a white diffuse surface returns, by adding up all texels.
glm::vec3 added_up(const EnvironmentMap& map, const glm::vec3& n) {
  glm::vec3 sum(0.0f);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      sum += std::max(glm::dot(n, direction_of_texel(map, x, y)), 0.0f) *
             solid_angle_of_texel(map, y) * map.at(x, y);
  return sum / std::numbers::pi_v<float>;
}

const glm::vec3 kNormals[] = {{0.0f, 1.0f, 0.0f},   {0.0f, -1.0f, 0.0f},  {1.0f, 0.0f, 0.0f},
                              {0.0f, 0.0f, -1.0f},  {0.6f, 0.48f, 0.64f}, {-0.6f, 0.64f, 0.48f},
                              {0.48f, -0.6f, 0.64f}};

TEST(LightProbe, lights_all_sides_alike_if_the_same_light_comes_from_everywhere) {
  const LightProbe probe =
      make_light_probe(environment(64, 32, [](const glm::vec3&) { return glm::vec3(3.0f); }), 0.5f);
  EXPECT_EQ(probe.key, glm::vec3(0.0f));
  const float white = returned(probe, kNormals[0]).x;
  EXPECT_GT(white, 0.5f);
  EXPECT_LE(white, 1.0f);
  for (const glm::vec3& n : kNormals) EXPECT_NEAR(returned(probe, n).y, white, 2e-3f);
  for (const glm::vec3& light : probe.glossy) EXPECT_NEAR(light.z, white, 2e-3f);
}

TEST(LightProbe, returns_as_much_diffuse_light_as_adding_up_the_environment) {
  const EnvironmentMap map = environment(96, 48, [](const glm::vec3& d) {
    return glm::vec3(0.4f) + 0.5f * glm::max(glm::vec3(d.y, 0.7f * d.y + 0.3f * d.x, d.z), 0.0f);
  });
  const LightProbe probe = make_light_probe(map, 0.5f);
  ASSERT_EQ(probe.key, glm::vec3(0.0f));
  // Probes are scaled, each by one factor.
  const float factor = returned(probe, kNormals[0]).x / added_up(map, kNormals[0]).x;
  for (const glm::vec3& n : kNormals) {
    const glm::vec3 expected = factor * added_up(map, n), is = returned(probe, n);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(is[i], expected[i], 0.03f * expected[i]);
  }
}

TEST(LightProbe, makes_the_sun_the_key_light_and_loses_none_of_its_light) {
  const EnvironmentMap map = environment(128, 64, [](const glm::vec3& d) {
    return glm::dot(d, glm::vec3(0.6f, 0.8f, 0.0f)) > 0.995f ? glm::vec3(900.0f, 800.0f, 600.0f)
                                                             : glm::vec3(0.5f, 0.6f, 0.8f);
  });
  const LightProbe probe = make_light_probe(map, 0.5f);
  EXPECT_GT(glm::dot(probe.key_direction, glm::vec3(0.6f, 0.8f, 0.0f)), 0.999f);
  EXPECT_GT(probe.key.x, probe.key.z);
  const auto lit = [&](const glm::vec3& n) {
    return returned(probe, n) + probe.key * std::max(glm::dot(n, probe.key_direction), 0.0f);
  };
  const float factor = lit(probe.key_direction).x / added_up(map, probe.key_direction).x;
  EXPECT_NEAR(lit(kNormals[0]).x, factor * added_up(map, kNormals[0]).x, 0.03f);
  EXPECT_NEAR(lit(kNormals[2]).y, factor * added_up(map, kNormals[2]).y, 0.03f);
}

TEST(LightProbe, is_finite_for_a_black_environment) {
  const LightProbe probe =
      make_light_probe(environment(4, 2, [](const glm::vec3&) { return glm::vec3(0.0f); }), 1.0f);
  for (const glm::vec3& light : probe.glossy) EXPECT_EQ(light, glm::vec3(0.0f));
  EXPECT_EQ(returned(probe, kNormals[0]), glm::vec3(0.0f));
}

}  // namespace
}  // namespace pointreel::light_probe_test
