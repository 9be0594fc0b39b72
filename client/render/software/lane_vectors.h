#pragma once

#include <glm/glm.hpp>

#include "client/render/software/lanes.h"

namespace pointreel {

/// Eight vectors that are computed with at once.
struct LaneVec {
  Lanes x, y, z;
};

POINTREEL_INLINE LaneVec operator+(const LaneVec& a, const LaneVec& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
POINTREEL_INLINE LaneVec operator-(const LaneVec& a, const LaneVec& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
POINTREEL_INLINE LaneVec operator*(const Lanes& s, const LaneVec& v) {
  return {s * v.x, s * v.y, s * v.z};
}
POINTREEL_INLINE LaneVec operator*(const LaneVec& a, const LaneVec& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
POINTREEL_INLINE LaneVec all_of(const glm::vec3& v) {
  return {Lanes{} + v.x, Lanes{} + v.y, Lanes{} + v.z};
}
POINTREEL_INLINE Lanes dot(const LaneVec& a, const LaneVec& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
POINTREEL_INLINE LaneVec choose(const LaneMask& mask, const LaneVec& a, const LaneVec& b) {
  return {mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z};
}
POINTREEL_INLINE LaneVec turned(const glm::mat3& by, const LaneVec& v) {
  return {by[0].x * v.x + by[1].x * v.y + by[2].x * v.z,
          by[0].y * v.x + by[1].y * v.y + by[2].y * v.z,
          by[0].z * v.x + by[1].z * v.y + by[2].z * v.z};
}
/// Points, transformed by an affine matrix.
POINTREEL_INLINE LaneVec moved(const glm::mat4& by, const LaneVec& v) {
  const auto row = [&](int i) POINTREEL_INLINED {
    return (by[0][i] * v.x + by[1][i] * v.y) + (by[2][i] * v.z + by[3][i]);
  };
  return {row(0), row(1), row(2)};
}
POINTREEL_INLINE glm::vec3 lane_of(const LaneVec& v, std::size_t lane) {
  return {v.x[lane], v.y[lane], v.z[lane]};
}
POINTREEL_INLINE void set_lane(LaneVec& v, std::size_t lane, const glm::vec3& to) {
  v.x[lane] = to.x;
  v.y[lane] = to.y;
  v.z[lane] = to.z;
}

POINTREEL_INLINE Lanes root_of(Lanes v) {
  for (std::size_t lane = 0; lane < kLanes; ++lane) v[lane] = __builtin_sqrtf(v[lane]);
  return v;
}
/// The largest integers that are no larger.
POINTREEL_INLINE LaneMask floor_of(const Lanes& v) {
  const auto cut = __builtin_convertvector(v, LaneMask);
  return cut + (__builtin_convertvector(cut, Lanes) > v);
}
POINTREEL_INLINE bool any_lane(const LaneMask& mask) {
  std::int64_t words[sizeof(LaneMask) / sizeof(std::int64_t)];
  std::memcpy(words, &mask, sizeof(mask));
  return (words[0] | words[1] | words[2] | words[3]) != 0;
}

}  // namespace pointreel
