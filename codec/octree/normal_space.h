#pragma once

#include <cmath>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "codec/octree/neighbor_prediction.h"

/// Normals as the transform works on them: x, y, z in steps of 1/8160. FORMAT.md, "Normals".
namespace pointreel {

inline constexpr std::int32_t kUnitNormal = 8160;

/// Of a unit vector times 32767, or zero where the normal is unknown.
inline Short4 value_from_normal(const glm::i16vec3& normal) {
  Int4 value{normal.x, normal.y, normal.z, 0};
  value = (value * kUnitNormal + (1 << 14)) >> 15;
  return stored_value(value + fourth_lane(0));
}

/// Unit length; zero, for unknown, where less than a quarter of it is left of the mean or of an
/// unknown normal among known ones.
inline glm::vec3 normal_from_value(const Short4& value) {
  const glm::vec3 v(value.lanes[0], value.lanes[1], value.lanes[2]);
  const float squared = glm::dot(v, v);
  constexpr float kLeast = kUnitNormal / 4;
  return squared < kLeast * kLeast ? glm::vec3(0.0f) : v / std::sqrt(squared);
}

/// The direction of a mean, however little of it is left, times 32767: of an inner node, whose
/// normals may point anywhere.
inline glm::i16vec3 mean_normal_from_value(const Short4& value) {
  const glm::vec3 v(value.lanes[0], value.lanes[1], value.lanes[2]);
  const float length = std::sqrt(glm::dot(v, v));
  return length > 0.0f ? glm::i16vec3(glm::round(v * (32767.0f / length))) : glm::i16vec3(0);
}

}  // namespace pointreel
