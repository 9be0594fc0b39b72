#pragma once

#include <algorithm>

namespace pointreel {

/// std::clamp before a conversion to an integer, for which NaN has no meaning: NaN becomes `most`.
inline float bounded(float v, float least, float most) {
  return std::max(least, std::min(most, v));
}

}  // namespace pointreel
