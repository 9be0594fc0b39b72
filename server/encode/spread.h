#pragma once

#include <vector>

namespace pointreel {

/// Median, smallest and largest of some values; all 0 if there are none.
struct Spread {
  double median = 0.0, min = 0.0, max = 0.0;
};
Spread spread_of(std::vector<double> values);

}  // namespace pointreel
