#pragma once

#include <cstddef>

namespace pointreel {

/// Number i of `count` places spread evenly over n, which are not fewer: the middles of equal
/// parts.
inline std::size_t spread_index(std::size_t i, std::size_t count, std::size_t n) {
  return (2 * i + 1) * n / (2 * count);
}

}  // namespace pointreel
