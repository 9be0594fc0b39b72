#include "client/prepare/node_radii.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "codec/core/build.h"
#include "common/base/blocks.h"

namespace pointreel {
namespace {

/// The square of half a cell's diagonal, in squares of its edge.
constexpr float kDiscAroundCell = 0.75f;
/// With less, surfels stay as small as their largest child, and pictures get holes: 1.4 adds holes
/// of 0.6 % in a picture 300 pixels high, and of 0.25 % in one of 700.
constexpr float kMostGrowth = 2.0f;

}  // namespace

std::vector<float> node_radii(const Svo& svo, const std::vector<float>& leaf_radii,
                              const Executor& executor) {
  std::vector<float> radii(svo.node_count());
  std::copy(leaf_radii.begin(), leaf_radii.end(), radii.begin() + svo.internal_count());
  for (int level = svo.depth - 1; level >= 0; --level) {
    const auto edge = static_cast<float>(svo.cell_size(level));
    const std::uint32_t first = svo.level_begin[static_cast<std::size_t>(level)];
    const Blocks blocks(executor, svo.node_count(level), kLeastPerBlock);
    for_each_block(executor, blocks, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t node = first + begin; node < first + end; ++node) {
        const float* const child = radii.data() + svo.first_child[node];
        const int children = std::popcount(svo.masks[node]);
        float area = 0.0f, largest = 0.0f;
        for (int c = 0; c < children; ++c) {
          area += child[c] * child[c];
          largest = std::max(largest, child[c]);
        }
        const float most = std::max(kDiscAroundCell * edge * edge, kMostGrowth * largest * largest);
        radii[node] = std::sqrt(std::min(area, most));
      }
    });
  }
  return radii;
}

}  // namespace pointreel
