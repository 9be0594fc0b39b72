#include "client/draft.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace pointreel {
namespace {

/// A hand notices no delay below it.
constexpr double kInTimeMs = 16.0;
/// Of a whole picture's time, by level: 916,000 surfels on software OpenGL.
constexpr std::array<double, Draft::kCoarsest + 1> kShare = {1.0, 0.3, 0.12};
constexpr int kUnknown = 2;  ///< level while nothing is known

}  // namespace

int Draft::reduction(bool hurried, std::uint64_t elements) {
  int level = 0;
  if (hurried && ms_per_element_ < 0.0) {
    level = kUnknown;
  } else if (hurried) {
    const double whole = ms_per_element_ * static_cast<double>(elements);
    while (level < kCoarsest && kShare[static_cast<std::size_t>(level)] * whole > kInTimeMs)
      ++level;
    level = std::max(level, level_);
  }
  level_ = level;
  return 1 << level;
}

void Draft::drew(std::uint64_t elements, double ms) {
  ms_per_element_ = ms / kShare[static_cast<std::size_t>(level_)] /
                    static_cast<double>(std::max<std::uint64_t>(elements, 1));
}

std::uint64_t element_count(const Scene& scene) {
  std::uint64_t count = 0;
  for (const PlacedFrame& placed : scene) {
    if (!placed.frame) continue;
    const std::uint64_t leaves = placed.frame->svo.leaf_count();
    count += leaves > 0 ? leaves : placed.frame->cloud.size();
  }
  return count;
}

}  // namespace pointreel
