#include "codec/video_encode/leftovers.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <unordered_map>

#include "codec/video_encode/filter_points.h"

namespace pointreel {
namespace {

/// Points farther than kNear pixels are left over, unless they are fewer than this share of all;
/// those farther than kVisible always are.
constexpr int kNear = 2, kVisible = 5;
constexpr double kMissing = 0.001;

/// Those of the points `of` the source that lie farther than `distance` pixels from any decoded
/// point.
std::vector<std::uint32_t> farther(const DecodedPoints& decoded, const SurfacePoints& source,
                                   const std::vector<std::uint32_t>& of, int distance,
                                   const Executor& executor) {
  return filter_points(of, executor, [&](std::uint32_t i) {
    // First in the view that the point faces, where it is most likely to be.
    const std::size_t best = faced_most(source.normals[i]);
    bool near = decoded.has_near(best, source.places[i], distance);
    for (std::size_t v = 0; v < kViews && !near; ++v)
      near = v != best && decoded.has_near(v, source.places[i], distance);
    return !near;
  });
}

/// Points that are kept, in cells of kNear pixels.
class Kept {
 public:
  bool has_near(const glm::vec3& place) const {
    const glm::ivec3 cell = glm::ivec3(place) / kNear;
    for (int n = 0; n < 27; ++n) {
      const auto found = cells_.find(key(cell + glm::ivec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1)));
      if (found == cells_.end()) continue;
      const glm::vec3 away = found->second - place;
      if (glm::dot(away, away) <= static_cast<float>(kNear * kNear)) return true;
    }
    return false;
  }
  /// Points are decoded to the middle of their cell.
  void add(const glm::vec3& place) {
    const glm::ivec3 cell = glm::ivec3(place) / kNear;
    cells_.emplace(key(cell), static_cast<float>(kNear) * (glm::vec3(cell) + 0.5f));
  }

 private:
  static std::uint64_t key(const glm::ivec3& cell) {
    const glm::u64vec3 c(cell + 1);
    return c.x | c.y << 20 | c.z << 40;
  }

  std::unordered_map<std::uint64_t, glm::vec3> cells_;
};

}  // namespace

std::vector<std::uint32_t> leftovers(const VideoGroup& group, const DecodedDepth& decoded,
                                     const SurfacePoints& source, const Executor& executor) {
  const DecodedPoints points(group, decoded);
  std::vector<std::uint32_t> all(source.size());
  std::iota(all.begin(), all.end(), 0u);
  // How far each of those that are left is away, from kNear to kVisible.
  std::vector<std::uint32_t> left = farther(points, source, all, kNear, executor);
  std::unordered_map<std::uint32_t, int> distance;
  std::vector<std::uint32_t> still = left;
  for (int d = kNear; d <= kVisible && !still.empty(); ++d) {
    if (d > kNear) still = farther(points, source, still, d, executor);
    for (const std::uint32_t i : still) distance[i] = d;
  }
  std::stable_sort(left.begin(), left.end(),
                   [&](auto a, auto b) { return distance[a] > distance[b]; });
  const auto most = static_cast<std::size_t>(kMissing * static_cast<double>(source.size()));
  std::size_t missing = left.size();
  std::vector<std::uint32_t> chosen;
  Kept kept;
  for (const std::uint32_t i : left) {
    if (missing <= most && distance[i] < kVisible) break;
    --missing;
    if (kept.has_near(source.places[i])) continue;
    kept.add(source.places[i]);
    chosen.push_back(i);
  }
  return chosen;
}

}  // namespace pointreel
