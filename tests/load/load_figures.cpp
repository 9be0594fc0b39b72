#include "tests/load/load_figures.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pointreel {

double LoadFigures::delay_ms(double share) const {
  const auto all = static_cast<double>(delays_ms.size() + incomplete + missing);
  const auto rank = static_cast<std::size_t>(std::max(0.0, std::ceil(share * all) - 1.0));
  if (rank >= delays_ms.size()) return std::numeric_limits<double>::infinity();
  return delays_ms[rank];
}

}  // namespace pointreel
