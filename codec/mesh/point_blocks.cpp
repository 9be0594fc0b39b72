#include "codec/mesh/point_blocks.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "codec/core/morton.h"
#include "common/base/blocks.h"

namespace pointreel {
namespace {

/// Calls found(key) for each block with a sample within reach of the point, except for some that
/// are only just too far away.
template <class Found>
void for_blocks_around(const glm::dvec3& place, float reach, const Found& found) {
  constexpr int kBits = PointBlocks::kBits;
  const glm::ivec3 low = glm::max(glm::ivec3(glm::ceil(place - double{reach})), 0) >> kBits;
  const glm::ivec3 high = glm::max(glm::ivec3(glm::floor(place + double{reach})), 0) >> kBits;
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) {
        const glm::dvec3 first = glm::dvec3(glm::ivec3(x, y, z) << kBits);
        const glm::dvec3 gap = place - glm::clamp(place, first, first + (PointBlocks::kEdge - 1.0));
        if (glm::dot(gap, gap) <= double{reach} * reach)
          found(morton_encode(glm::uvec3(static_cast<unsigned>(x), static_cast<unsigned>(y),
                                         static_cast<unsigned>(z))));
      }
    }
  }
}

}  // namespace

PointBlocks::PointBlocks(const PointCloud& cloud, const MeshGrid& grid,
                         std::span<const float> reaches, const Executor& executor) {
  const Blocks parts(executor, cloud.size(), kLeastPerBlock);
  std::vector<std::vector<KeyIndex>> seen(parts.count());
  for_each_block(executor, parts, [&](std::size_t part, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      for_blocks_around(grid.inside(cloud.positions[i]), reaches[i], [&](std::uint64_t key) {
        seen[part].emplace_back(key, static_cast<std::uint32_t>(i));
      });
    }
  });
  std::uint64_t keys = 0;
  for (std::vector<KeyIndex>& part : seen) {
    seen_.insert(seen_.end(), part.begin(), part.end());
    part = {};
  }
  for (const KeyIndex& item : seen_) keys |= item.key;
  radix_sort(seen_, static_cast<int>(std::bit_width(keys)), executor);
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    if (i > 0 && seen_[i].key == seen_[i - 1].key) continue;
    by_key_.emplace(seen_[i].key, static_cast<std::uint32_t>(starts_.size()));
    starts_.push_back(i);
  }
}

std::uint64_t PointBlocks::memory(std::span<const float> reaches) {
  double blocks = 0.0;
  for (const float reach : reaches) {
    const double along = 2.0 * double{reach} / kEdge + 1.0;
    // Of a cube of blocks around a point, those at the corners are too far away.
    blocks += 0.75 * along * along * along;
  }
  // Sorting takes as much again.
  return static_cast<std::uint64_t>(2.0 * sizeof(KeyIndex) * blocks);
}

glm::ivec3 PointBlocks::corner(std::uint32_t block) const {
  return glm::ivec3(morton_decode(seen_[starts_[block]].key)) << kBits;
}

std::uint32_t PointBlocks::find(const glm::ivec3& corner) const {
  if (corner.x < 0 || corner.y < 0 || corner.z < 0) return kNone;
  const auto at = by_key_.find(morton_encode(glm::uvec3(corner) >> unsigned{kBits}));
  return at == by_key_.end() ? kNone : at->second;
}

std::span<const KeyIndex> PointBlocks::points(std::uint32_t block) const {
  const std::size_t end = block + 1 < starts_.size() ? starts_[block + 1] : seen_.size();
  return std::span(seen_).subspan(starts_[block], end - starts_[block]);
}

}  // namespace pointreel
