#pragma once

#include <cstdint>

#include <glm/glm.hpp>

#include "datasets_synthetic/random.h"

namespace pointreel {

/// Approximately normal with standard deviation 1 and never beyond +-4.9: the scaled sum of eight
/// uniform 16-bit numbers.
inline double quick_normal(Random& random) {
  double sum = 0.0;
  for (int draw = 0; draw < 2; ++draw) {
    const std::uint64_t bits = random.bits();
    sum += static_cast<double>((bits & 0xffff) + (bits >> 16 & 0xffff) + (bits >> 32 & 0xffff) +
                               (bits >> 48));
  }
  return (sum - 4.0 * 0xffff) * (1.0 / 0xffff) * 1.22474487139158905;
}

/// The error of where a device is believed to be: a small rigid motion.
struct Calibration {
  glm::dvec3 shift{0.0};  ///< metres
  glm::dvec3 turn{0.0};   ///< radians about each axis, through the origin

  glm::dvec3 apply(const glm::dvec3& p) const { return p + shift + glm::cross(turn, p); }
};

/// A calibration error whose shift and turn have these standard deviations along each axis.
inline Calibration random_calibration(Random random, double shift, double turn) {
  Calibration calibration;
  for (int axis = 0; axis < 3; ++axis) {
    calibration.shift[axis] = shift * random.normal();
    calibration.turn[axis] = turn * random.normal();
  }
  return calibration;
}

}  // namespace pointreel
