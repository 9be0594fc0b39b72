#include "codec/octree/normal_noise.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "codec/octree/normal_space.h"

namespace pointreel {
namespace {

/// With fewer pairs, the median would say little.
constexpr std::size_t kFewestPairs = 64;
/// The median length of the difference of two vectors whose two tangential components each have
/// noise of 1: sqrt(2) times that of one, sqrt(2 ln 2).
constexpr double kMedianDifference = 1.6651;

/// The step, relative to the noise. It saves most of the bits of the normals that depth cameras
/// measure (codec/QUALITY.md). With 3, the detail of clean captures begins to count as noise.
constexpr double kStepOfNoise = 2.5;

bool is_known(const Short4& value) { return normal_from_value(value) != glm::vec3(0.0f); }

/// The squared difference between the first two leaves below each node of a level.
std::vector<float> squared_differences(const Svo& svo, int level, std::span<const Short4> leaves) {
  std::vector<float> squares;
  // The first leaf below each node of the level below.
  const auto first_leaf = [&](std::uint32_t node) {
    while (node < svo.internal_count()) node = svo.first_child[node];
    return leaves[node - svo.internal_count()];
  };
  const std::size_t l = static_cast<std::size_t>(level);
  for (std::uint32_t node = svo.level_begin[l]; node < svo.level_begin[l + 1]; ++node) {
    if (std::has_single_bit(svo.masks[node])) continue;
    const std::uint32_t child = svo.first_child[node];
    const Short4 a = first_leaf(child), b = first_leaf(child + 1);
    if (!is_known(a) || !is_known(b)) continue;
    const Int4 d = load(a) - load(b);
    squares.push_back(static_cast<float>(d[0]) * static_cast<float>(d[0]) +
                      static_cast<float>(d[1]) * static_cast<float>(d[1]) +
                      static_cast<float>(d[2]) * static_cast<float>(d[2]));
  }
  return squares;
}

}  // namespace

double normal_noise(const Svo& svo, std::span<const Short4> leaves) {
  for (int level = svo.depth - 1; level >= 0; --level) {
    std::vector<float> squares = squared_differences(svo, level, leaves);
    if (squares.size() < kFewestPairs) continue;
    const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
    std::nth_element(squares.begin(), middle, squares.end());
    return std::sqrt(static_cast<double>(*middle)) / kMedianDifference;
  }
  return 0.0;
}

CoefficientSteps no_finer_than_noise(const CoefficientSteps& steps, double noise) {
  // A step is in units of 64 / 256 values.
  const double factor = kStepOfNoise * 4.0 * noise / steps.luma;
  if (factor <= 1.0) return steps;
  const auto scaled = [&](std::uint16_t step) {
    return static_cast<std::uint16_t>(std::min(std::lround(factor * step), 65535l));
  };
  return {scaled(steps.luma), scaled(steps.chroma)};
}

}  // namespace pointreel
