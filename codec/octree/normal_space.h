#pragma once

#include <cmath>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "codec/octree/attribute_value.h"

/// The normals that the transform works on: x, y and z in units of 1/8160. FORMAT.md, "Normals".
namespace pointreel {

inline constexpr std::int32_t kUnitNormal = 8160;

/// `normal`: a unit vector times 32767, or zero if unknown.
inline Short4 value_from_normal(const glm::i16vec3& normal) {
  Int4 value{normal.x, normal.y, normal.z, 0};
  value = (value * kUnitNormal + (1 << 14)) >> 15;
  return stored_value(value + fourth_lane(0));
}

/// The unit normal of a decoded value. It is zero, which means unknown, if the value's length is
/// less than a quarter: normals that cancel out in a mean, or an unknown normal among known ones.
inline glm::vec3 normal_from_value(const Short4& value) {
  const glm::vec3 v(value.lanes[0], value.lanes[1], value.lanes[2]);
  const float squared = glm::dot(v, v);
  constexpr float kLeast = kUnitNormal / 4;
  return squared < kLeast * kLeast ? glm::vec3(0.0f) : v / std::sqrt(squared);
}

/// The unit vector along the value, times 32767 and rounded; zero if the value is shorter than
/// `least`.
inline glm::i16vec3 direction_from_value(const Short4& value, float least) {
  typedef float FourFloats __attribute__((vector_size(16)));
  const FourFloats v = __builtin_convertvector(load(value) & Int4{-1, -1, -1, 0}, FourFloats);
  const FourFloats squares = v * v;
  const float squared = squares[0] + squares[1] + squares[2];
  if (squared == 0.0f || squared < least * least) return glm::i16vec3(0);
  const FourFloats scaled = v * (32767.0f / std::sqrt(squared));
  // Rounds half away from zero, as std::round does, but inline.
  const FourFloats half =
      scaled < 0.0f ? FourFloats{-0.5f, -0.5f, -0.5f, 0.0f} : FourFloats{0.5f, 0.5f, 0.5f, 0.0f};
  const Int4 rounded = __builtin_convertvector(scaled + half, Int4);
  return {static_cast<std::int16_t>(rounded[0]), static_cast<std::int16_t>(rounded[1]),
          static_cast<std::int16_t>(rounded[2])};
}

/// normal_from_value times 32767.
inline glm::i16vec3 short_normal_from_value(const Short4& value) {
  return direction_from_value(value, kUnitNormal / 4);
}

/// The direction of the value times 32767, however short it is. For inner nodes, whose leaves may
/// have very different normals.
inline glm::i16vec3 mean_normal_from_value(const Short4& value) {
  return direction_from_value(value, 0.0f);
}

}  // namespace pointreel
