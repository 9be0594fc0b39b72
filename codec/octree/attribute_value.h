#pragma once

#include <cstdint>

#include "codec/octree/int4.h"

/// How the values of nodes are kept while attributes are coded: three components, and a fourth lane
/// for prediction.
namespace pointreel {

/// The fourth lane is 1, which counts nodes, plus kActivityUnit times the node's activity, which is
/// how much there was to code in its parent.
inline constexpr std::int32_t kActivityUnit = 256;
inline constexpr std::int32_t kMostActivity = 127;

/// The range to which stored values are clamped.
inline constexpr std::int32_t kLeastValue = -16384, kMostValue = 16383;

/// Selects the lanes that hold a value's components.
inline constexpr Int4 kComponents = {-1, -1, -1, 0};

/// The fourth lane of a node with this activity; the other lanes are 0.
inline Int4 fourth_lane(std::int32_t activity) {
  return Int4{0, 0, 0, 1 + activity * kActivityUnit};
}

inline std::int32_t activity_of(const Short4& value) {
  return static_cast<std::uint16_t>(value.lanes[3]) / kActivityUnit;
}

/// Clamps the components and keeps the fourth lane.
inline Short4 stored_value(const Int4& value) {
  constexpr Int4 kLeast = {kLeastValue, kLeastValue, kLeastValue, 0};
  constexpr Int4 kMost = {kMostValue, kMostValue, kMostValue, 32767};
  return narrow(min(max(value, kLeast), kMost));
}

}  // namespace pointreel
