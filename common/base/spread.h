#pragma once

#include <cstddef>

namespace pointreel {

/// The index of sample i when `count` samples are spread evenly over n >= count items: the middle
/// of the i-th of `count` equal parts.
inline std::size_t spread_index(std::size_t i, std::size_t count, std::size_t n) {
  return (2 * i + 1) * n / (2 * count);
}

}  // namespace pointreel
