#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "codec/surface/lanes.h"

namespace pointreel {

struct PointNormal {
  glm::vec3 position, normal;
};

/// A few points that lie close together.
struct alignas(sizeof(Lanes)) PointRow {
  Lanes x, y, z;                             ///< infinite in lanes without a point
  std::array<std::uint32_t, kLanes> points;  ///< their numbers, ascending
  std::uint32_t count = 0;                   ///< at least 1
  glm::vec3 center{0.0f};                    ///< of a sphere around them
  float radius = 0.0f;                       ///< of that sphere
};

/// Distributes some of the points over rows that are as compact as possible, and appends these. All
/// rows but one are full. Changes the order of `points`. O(n log n).
void append_rows(std::span<const PointNormal> all, std::span<std::uint32_t> points,
                 std::vector<PointRow>& rows);

}  // namespace pointreel
