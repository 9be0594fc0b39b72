#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <glm/glm.hpp>

namespace pointreel {

/// Where the middle half of some points lies. A quarter of them may be strays.
struct MiddleHalf {
  glm::dvec3 middle{0.0};  ///< the median on each axis
  double reach = 0.0;      ///< of the axis on which the median is furthest from zero
  double spread = 0.0;     ///< of the axis on which the middle half is longest

  /// Whether it is further from zero than so many times as long.
  bool is_far(double spreads) const { return reach > spreads * spread; }

  /// An origin for floats: below the middle, at whole coordinates, so that small whole ones stay
  /// what they are; or, where points are closer together, at multiples of a power of two that is no
  /// larger than they spread.
  glm::dvec3 origin() const {
    if (!(spread > 0.0)) return glm::floor(middle);
    const double unit = std::min(1.0, std::exp2(std::floor(std::log2(spread))));
    return unit * glm::floor(middle / unit);
  }
};

/// `values`: the coordinates of the points by axis, at least one each. They are sorted.
inline MiddleHalf middle_half(std::array<std::vector<double>, 3>& values) {
  MiddleHalf half;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double>& sorted = values[static_cast<std::size_t>(axis)];
    std::sort(sorted.begin(), sorted.end());
    half.middle[axis] = sorted[sorted.size() / 2];
    half.reach = std::max(half.reach, std::abs(half.middle[axis]));
    half.spread = std::max(half.spread, sorted[sorted.size() * 3 / 4] - sorted[sorted.size() / 4]);
  }
  return half;
}

}  // namespace pointreel
