#include "client/strips/patches.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "client/strips/delaunay.h"
#include "client/strips/kept_patches.h"
#include "common/base/for_each.h"

namespace pointreel {
namespace {

struct SurfelRange {
  std::uint32_t begin, end;
};

/// A box around surfels.
struct Bounds {
  glm::vec3 min{0.0f}, max{0.0f};

  Bounds() = default;
  explicit Bounds(std::span<const glm::vec3> positions) : min(positions[0]), max(positions[0]) {
    for (const glm::vec3& p : positions) {
      min = glm::min(min, p);
      max = glm::max(max, p);
    }
  }
  /// The square of the distance of a point from the box.
  float distance2(const glm::vec3& p) const {
    const glm::vec3 d = glm::max(glm::max(min - p, p - max), 0.0f);
    return glm::dot(d, d);
  }
  /// The same of another box, which is no more than that of any point in it, also rounded.
  float distance2(const Bounds& other) const {
    const glm::vec3 d = glm::max(glm::max(min - other.max, other.min - max), 0.0f);
    return glm::dot(d, d);
  }
};

/// Triangulates patches, one after another. Keeps its buffers.
class Triangulation {
 public:
  /// `boxes`: around the surfels of each patch.
  Triangulation(const StripSurfels& surfels, const StrippingTree& tree, const InflationRule& rule,
                std::span<const Bounds> boxes)
      : surfels_(surfels), tree_(tree), rule_(rule), boxes_(boxes) {}

  /// Appends the triangles of a patch.
  void run(std::size_t number, std::vector<PatchTriangle>& out) {
    const PatchNode& patch = tree_.nodes[tree_.patches[number]];
    const PatchPlane plane = patch_plane(surfels_, patch.begin, patch.end);
    gather(number, plane);
    project(plane);
    // Triangles are put into the order of their lowest corners by counting, and then, the few that
    // share it, by comparing.
    kept_.clear();
    places_.assign(members_.size() + 1, 0);
    for (const Delaunay::Triangle& triangle : delaunay_.run(points_)) {
      if (!is_kept(triangle)) continue;
      const std::size_t lowest = lowest_corner(triangle);
      ++places_[triangle[lowest] + 1u];
      PatchTriangle to;
      to.inner = true;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t from = (lowest + i) % 3;
        to.corners[i] = members_[triangle[from]];
        to.inner = to.inner && own_[triangle[from]] != 0;
      }
      kept_.push_back({triangle[lowest], to});
    }
    std::partial_sum(places_.begin(), places_.end(), places_.begin());
    const std::size_t first = out.size();
    out.resize(first + kept_.size());
    for (const auto& [lowest, triangle] : kept_) {
      std::size_t at = first + places_[lowest]++;
      for (; at > first && triangle.corners < out[at - 1].corners &&
             out[at - 1].corners[0] == triangle.corners[0];
           --at)
        out[at] = out[at - 1];
      out[at] = triangle;
    }
  }

 private:
  /// Collects the surfels of a patch and those near it, by their index.
  void gather(std::size_t number, const PatchPlane& plane) {
    const Svo& svo = surfels_.svo;
    const PatchNode& patch = tree_.nodes[tree_.patches[number]];
    const float reach = inflation_reach(surfels_, patch, rule_), reach2 = reach * reach;
    const PatchNode& node = node_of_reach(svo, tree_, patch, reach);
    ranges_.clear();
    for (const std::uint32_t around : node.around) {
      if (around == kNoNode) continue;
      const auto [begin, end] = tree_.surfels_below(svo, around, node.level);
      ranges_.push_back({begin, end});
    }
    std::sort(ranges_.begin(), ranges_.end(),
              [](const SurfelRange& a, const SurfelRange& b) { return a.begin < b.begin; });
    const Bounds& box = boxes_[number];
    members_.clear();
    own_.clear();
    for (const SurfelRange& range : ranges_) {
      // The parts of the range that belong to one patch each. Most are too far away as a whole.
      for (std::uint32_t begin = range.begin, end; begin < range.end; begin = end) {
        const std::uint32_t owner = tree_.patch_of[begin];
        end = std::min(range.end, tree_.nodes[tree_.patches[owner]].end);
        if (box.distance2(boxes_[owner]) > reach2) continue;
        if (!gather({begin, end}, owner == number, box, reach2, plane)) return;
      }
    }
  }

  /// The same for surfels that belong to one patch. Returns false if there are as many as there may
  /// be.
  bool gather(const SurfelRange& range, bool own, const Bounds& box, float reach2,
              const PatchPlane& plane) {
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      if (!own) {
        if (!(box.distance2(surfels_.positions[i]) <= reach2)) continue;
        const float cosine = glm::dot(surfels_.normals[i], plane.normal);
        if ((surfels_.lines ? std::abs(cosine) : cosine) < rule_.least_cosine &&
            surfels_.normals[i] != glm::vec3(0.0f))
          continue;
      }
      if (members_.size() == Delaunay::kMostPoints) return false;
      members_.push_back(i);
      own_.push_back(own ? 1 : 0);
    }
    return true;
  }

  /// Projects the members into the plane, and rounds their coordinates to as many steps as there
  /// are.
  void project(const PatchPlane& plane) {
    const glm::vec3 n = plane.normal;
    const glm::vec3 side =
        std::abs(n.x) < 0.6f ? glm::vec3(1.0f, 0.0f, 0.0f) : glm::vec3(0.0f, 1.0f, 0.0f);
    const glm::vec3 u = glm::normalize(glm::cross(side, n)), v = glm::cross(n, u);
    flat_.clear();
    glm::vec2 most(0.0f);
    for (const std::uint32_t i : members_) {
      const glm::vec3 d = surfels_.positions[i] - plane.center;
      flat_.push_back({glm::dot(d, u), glm::dot(d, v)});
      most = glm::max(most, glm::abs(flat_.back()));
    }
    const float farthest = std::max(most.x, most.y);
    const float scale = farthest > 0.0f ? static_cast<float>(Delaunay::kReach) / farthest : 0.0f;
    // Halves need not be rounded to either side. In this order, what is not a number, as of points
    // that are too far apart, is at the lower end.
    constexpr float kMiddle = 8192.5f, kReach = Delaunay::kReach;
    const auto step_of = [scale](float along) {
      const float at = scale * along + kMiddle;
      return static_cast<int>(std::min(kMiddle + kReach, std::max(kMiddle - kReach, at))) - 8192;
    };
    points_.clear();
    for (const glm::vec2& p : flat_) points_.emplace_back(step_of(p.x), step_of(p.y));
  }

  bool is_kept(const Delaunay::Triangle& triangle) const {
    const auto [a, b, c] = triangle;
    return (own_[a] | own_[b] | own_[c]) != 0 && short_enough(members_[a], members_[b]) &&
           short_enough(members_[b], members_[c]) && short_enough(members_[c], members_[a]);
  }

  static std::size_t lowest_corner(const Delaunay::Triangle& triangle) {
    const auto [a, b, c] = triangle;
    return a < b ? (a < c ? 0 : 2) : (b < c ? 1 : 2);
  }

  bool short_enough(std::uint32_t a, std::uint32_t b) const {
    const float most = rule_.longest * (surfels_.radii[a] + surfels_.radii[b]);
    const glm::vec3 d = surfels_.positions[a] - surfels_.positions[b];
    return glm::dot(d, d) <= most * most;
  }

  const StripSurfels& surfels_;
  const StrippingTree& tree_;
  const InflationRule& rule_;
  const std::span<const Bounds> boxes_;
  std::vector<SurfelRange> ranges_;
  std::vector<std::uint32_t> members_;  ///< of the inflated patch, by their index
  std::vector<std::uint8_t> own_;       ///< whether they are the patch's own
  std::vector<glm::vec2> flat_;
  std::vector<glm::ivec2> points_;
  Delaunay delaunay_;
  std::vector<std::uint32_t> places_;
  std::vector<std::pair<std::uint16_t, PatchTriangle>> kept_;
};

}  // namespace

float inflation_reach(const StripSurfels& surfels, const PatchNode& patch,
                      const InflationRule& rule) {
  float radii = 0.0f;
  for (std::uint32_t i = patch.begin; i < patch.end; ++i) radii += surfels.radii[i];
  return radii * (rule.distance / static_cast<float>(patch.end - patch.begin));
}

const PatchNode& node_of_reach(const Svo& svo, const StrippingTree& tree, const PatchNode& patch,
                               float reach) {
  const PatchNode* node = &patch;
  while (svo.cell_size(node->level) < reach && node->level > 0) node = &tree.nodes[node->parent];
  return *node;
}

Patches::Patches(const StripSurfels& surfels, const StrippingTree& tree, const InflationRule& rule,
                 const Executor& executor, const KeptPatches* kept)
    : patches_(tree.patches.size()), blocks_((tree.patches.size() + kBlock - 1) / kBlock) {
  const auto in_blocks = [&](const std::function<void(std::size_t, std::size_t)>& work) {
    for_each(executor, static_cast<int>(blocks_.size()), [&](int number) {
      const std::size_t begin = static_cast<std::size_t>(number) * kBlock;
      work(begin, std::min(begin + kBlock, patches_.size()));
    });
  };
  std::vector<Bounds> boxes(patches_.size());
  in_blocks([&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const PatchNode& patch = tree.nodes[tree.patches[i]];
      boxes[i] = Bounds(surfels.positions.subspan(patch.begin, patch.end - patch.begin));
    }
  });
  in_blocks([&](std::size_t first, std::size_t last) {
    std::vector<PatchTriangle>& out = blocks_[first / kBlock];
    Triangulation triangulation(surfels, tree, rule, boxes);
    for (std::size_t i = first; i < last; ++i) {
      const auto begin = static_cast<std::uint32_t>(out.size());
      if (kept == nullptr || !kept->append_triangles(i, out)) triangulation.run(i, out);
      patches_[i] = {begin, static_cast<std::uint32_t>(out.size())};
    }
  });
}

}  // namespace pointreel
