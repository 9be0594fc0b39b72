#include "codec/surface/leaf_heights.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "codec/surface/leaf_pairs.h"

namespace pointreel {
namespace {

/// The cosine of the largest angle between the normals of neighbours that are on one surface.
constexpr float kLeastLeafCosine = 0.3f;
/// More gain less than 1 %.
constexpr int kRounds = 3;

/// What two neighbours tell each other.
struct Link {
  std::uint32_t first, second;
  float weight;  ///< below 0 if the signs of their normals differ
  float rise;    ///< from the first to the second along the mean of their normals, in cells
};

std::vector<Link> find_links(const Svo& svo, std::span<const glm::vec3> normals, bool lines) {
  std::vector<Link> links;
  const std::vector<LeafPair> pairs = leaf_pairs(svo);
  links.reserve(pairs.size());
  for (const auto& [first, second, place] : pairs) {
    const glm::vec3 way(static_cast<float>(place % 3) - 1.0f,
                        static_cast<float>(place / 3 % 3) - 1.0f,
                        static_cast<float>(place / 9) - 1.0f);
    const float cosine = glm::dot(normals[first], normals[second]);
    if ((lines ? std::abs(cosine) : cosine) < kLeastLeafCosine) continue;
    const float sign = cosine < 0.0f ? -1.0f : 1.0f;
    links.push_back(
        {first, second, cosine, 0.5f * glm::dot(way, normals[first] + sign * normals[second])});
  }
  return links;
}

}  // namespace

std::vector<float> leaf_heights(const Svo& svo, std::span<const glm::i16vec3> normals, bool lines) {
  const std::size_t leaves = svo.leaf_count();
  std::vector<glm::vec3> unit(leaves);
  std::ranges::transform(normals, unit.begin(),
                         [](const glm::i16vec3& n) { return glm::vec3(n) / 32767.0f; });
  const std::vector<Link> links = find_links(svo, unit, lines);
  struct Sum {
    float weight, height;
  };
  std::vector<Sum> sums(leaves);
  std::vector<float> heights(leaves, 0.0f);  // in cells
  for (int round = 0; round < kRounds; ++round) {
    std::ranges::transform(heights, sums.begin(), [](float height) { return Sum{1.0f, height}; });
    for (const auto& [first, second, signed_weight, rise] : links) {
      const float weight = std::abs(signed_weight);
      sums[first].weight += weight;
      sums[first].height += weight * rise + signed_weight * heights[second];
      sums[second].weight += weight;
      sums[second].height += signed_weight * (heights[first] - rise);
    }
    for (std::size_t i = 0; i < leaves; ++i) {
      const glm::vec3 n = glm::abs(unit[i]);
      const float most = 0.5f * (n.x + n.y + n.z);
      heights[i] = std::clamp(sums[i].height / sums[i].weight, -most, most);
    }
  }
  const auto cell = static_cast<float>(svo.cell_size(svo.depth));
  for (float& height : heights) height *= cell;
  return heights;
}

}  // namespace pointreel
