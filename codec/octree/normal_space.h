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

/// Times 32767, rounded; zero where less than `least` is left of it.
inline glm::i16vec3 direction_from_value(const Short4& value, float least) {
  typedef float Float4 __attribute__((vector_size(16)));
  const Float4 v = __builtin_convertvector(load(value) & Int4{-1, -1, -1, 0}, Float4);
  const Float4 squares = v * v;
  const float squared = squares[0] + squares[1] + squares[2];
  if (squared == 0.0f || squared < least * least) return glm::i16vec3(0);
  const Float4 scaled = v * (32767.0f / std::sqrt(squared));
  // Half away from zero, as std::round, which compilers call out of line.
  const Float4 half =
      scaled < 0.0f ? Float4{-0.5f, -0.5f, -0.5f, 0.0f} : Float4{0.5f, 0.5f, 0.5f, 0.0f};
  const Int4 rounded = __builtin_convertvector(scaled + half, Int4);
  return {static_cast<std::int16_t>(rounded[0]), static_cast<std::int16_t>(rounded[1]),
          static_cast<std::int16_t>(rounded[2])};
}

/// normal_from_value, times 32767.
inline glm::i16vec3 short_normal_from_value(const Short4& value) {
  return direction_from_value(value, kUnitNormal / 4);
}

/// The direction of a mean, however little of it is left, times 32767: of an inner node, whose
/// normals may point anywhere.
inline glm::i16vec3 mean_normal_from_value(const Short4& value) {
  return direction_from_value(value, 0.0f);
}

}  // namespace pointreel
