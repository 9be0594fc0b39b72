#pragma once

#include <cmath>

namespace pointreel {

inline constexpr double kPi = 3.14159265358979323846;

/// The sine of an angle in radians to within 1e-11, for |angle| below about a million. It uses
/// additions and multiplications only, because the last bit of libm's sine differs between machines
/// and synthetic data must be the same everywhere.
inline double sine(double angle) {
  double x = angle - 2.0 * kPi * std::floor(angle / (2.0 * kPi) + 0.5);  // -pi to pi
  if (x > 0.5 * kPi) x = kPi - x;
  if (x < -0.5 * kPi) x = -kPi - x;
  double term = x, sum = x;  // the Taylor series up to x^17
  for (int n = 3; n <= 17; n += 2) {
    term *= -x * x / static_cast<double>(n * (n - 1));
    sum += term;
  }
  return sum;
}

inline double cosine(double angle) { return sine(angle + 0.5 * kPi); }

}  // namespace pointreel
