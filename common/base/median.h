#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace pointreel {

/// The middle one of the values in their order, the greater of two; there is at least one. O(n).
template <class T>
T median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Median, smallest and largest of some values; all 0 if there are none.
struct Spread {
  double median = 0.0, min = 0.0, max = 0.0;
};
inline Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  const double median =
      values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
  return {median, values.front(), values.back()};
}

}  // namespace pointreel
