#pragma once

#include <cmath>
#include <limits>
#include <vector>

namespace pointreel::golden {

/// Values to be compared by their bytes: NaN, which has many forms, becomes infinity.
inline std::vector<float> known_as_number(std::vector<float> values) {
  for (float& value : values)
    if (std::isnan(value)) value = std::numeric_limits<float>::infinity();
  return values;
}

}  // namespace pointreel::golden
