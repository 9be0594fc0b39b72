#include "client/scene/environment_map.h"

#include <cmath>
#include <numbers>

namespace pointreel {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

float smoothstep(float from, float to, float v) {
  const float t = glm::clamp((v - from) / (to - from), 0.0f, 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

/// A round lamp with a soft rim.
struct Lamp {
  float azimuth, height;   ///< degrees to the right of the viewer's back, and above the horizon
  float radius, softness;  ///< degrees
  glm::vec3 light;
};

constexpr Lamp kLamps[] = {
    {-38.0f, 42.0f, 12.0f, 4.0f, {26.0f, 24.6f, 22.6f}},
    {62.0f, 14.0f, 26.0f, 12.0f, {0.95f, 1.0f, 1.1f}},
    {152.0f, 38.0f, 14.0f, 6.0f, {4.2f, 4.3f, 4.5f}},
};

}  // namespace

glm::vec3 direction_of_texel(const EnvironmentMap& map, int x, int y) {
  const float theta = kPi * (static_cast<float>(y) + 0.5f) / static_cast<float>(map.height);
  const float phi =
      kPi * (2.0f * (static_cast<float>(x) + 0.5f) / static_cast<float>(map.width) - 1.0f);
  return {std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi)};
}

float solid_angle_of_texel(const EnvironmentMap& map, int y) {
  const float step = kPi / static_cast<float>(map.height);
  return 2.0f * kPi / static_cast<float>(map.width) *
         (std::cos(step * static_cast<float>(y)) - std::cos(step * static_cast<float>(y + 1)));
}

EnvironmentMap studio_environment() {
  EnvironmentMap map{128, 64, {}};
  map.texels.resize(128 * 64);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const glm::vec3 d = direction_of_texel(map, x, y);
      // Walls, a brighter ceiling, and a floor that returns some warm light.
      glm::vec3 light = glm::mix(glm::vec3(0.15f, 0.14f, 0.13f), glm::vec3(0.20f, 0.21f, 0.23f),
                                 smoothstep(-0.5f, 0.2f, d.y));
      light = glm::mix(light, glm::vec3(0.50f, 0.52f, 0.55f), smoothstep(0.3f, 1.0f, d.y));
      for (const Lamp& lamp : kLamps) {
        const float azimuth = glm::radians(lamp.azimuth), height = glm::radians(lamp.height);
        const glm::vec3 to_lamp(std::cos(height) * std::sin(azimuth), std::sin(height),
                                std::cos(height) * std::cos(azimuth));
        const float angle = glm::degrees(std::acos(glm::clamp(glm::dot(d, to_lamp), -1.0f, 1.0f)));
        light += lamp.light * (1.0f - smoothstep(lamp.radius - lamp.softness,
                                                 lamp.radius + lamp.softness, angle));
      }
      map.at(x, y) = light;
    }
  }
  return map;
}

}  // namespace pointreel
