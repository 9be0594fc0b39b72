#pragma once

#include <cmath>

namespace pointreel {

/// The transfer functions of IEC 61966-2-1. All values are from 0 to 1.
template <class Real>
Real linear_from_srgb(Real c) {
  return c <= Real(0.04045) ? c / Real(12.92)
                            : std::pow((c + Real(0.055)) / Real(1.055), Real(2.4));
}

template <class Real>
Real srgb_from_linear(Real c) {
  return c <= Real(0.0031308) ? Real(12.92) * c
                              : Real(1.055) * std::pow(c, Real(1) / Real(2.4)) - Real(0.055);
}

}  // namespace pointreel
