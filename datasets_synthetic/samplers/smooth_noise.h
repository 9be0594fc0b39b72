#pragma once

#include <cmath>
#include <cstdint>

#include "datasets_synthetic/random.h"
#include "datasets_synthetic/samplers/measurement_error.h"

namespace pointreel {

/// A random function of the pixels of an image: approximately normal with standard deviation 1
/// everywhere, similar at neighbouring pixels, and independent further apart than two grains.
class SmoothNoise {
 public:
  SmoothNoise(std::uint64_t seed, int grain) : seed_(seed), grain_(grain) {}

  /// Coordinates from 0 to below 2^30.
  double at(int x, int y) const {
    const int left = x / grain_, below = y / grain_;
    const double u = weight(x - left * grain_), v = weight(y - below * grain_);
    const double sum = (1.0 - v) * ((1.0 - u) * node(left, below) + u * node(left + 1, below)) +
                       v * ((1.0 - u) * node(left, below + 1) + u * node(left + 1, below + 1));
    // The variance of a sum of independent numbers is the sum of the squares of their weights.
    return sum / std::sqrt((u * u + (1.0 - u) * (1.0 - u)) * (v * v + (1.0 - v) * (1.0 - v)));
  }

 private:
  double weight(int within) const {
    const double s = within / static_cast<double>(grain_);
    return s * s * (3.0 - 2.0 * s);
  }

  double node(int i, int j) const {
    Random random(seed_, static_cast<std::uint64_t>(i) << 32 | static_cast<std::uint32_t>(j));
    return quick_normal(random);
  }

  std::uint64_t seed_;
  int grain_;
};

}  // namespace pointreel
