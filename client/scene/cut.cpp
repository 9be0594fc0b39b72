#include "client/scene/cut.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace pointreel {
namespace {

struct Plane {
  glm::vec3 normal;
  float offset;
  float distance(const glm::vec3& p) const { return glm::dot(normal, p) + offset; }
};

enum class Side { outside, crossing, inside };

/// The frustum and the size criterion, with the edge of the octree's cube as the unit.
class View {
 public:
  View(const Cube& cube, const Camera& camera, glm::ivec2 size, float pixel_size) {
    const double unit = 1.0 / cube.edge;
    const glm::dmat3 axes = camera.axes();
    const glm::dvec3 eye = (camera.eye() - cube.origin) * unit;
    const double ty = std::tan(0.5 * camera.fov_y);
    const double tx = ty * size.x / size.y;
    near_ = static_cast<float>(camera.near_plane() * unit);
    forward_ = plane(-axes[2], eye, 0.0);
    sides_ = {plane(glm::normalize(axes[0] - tx * axes[2]), eye, 0.0),
              plane(glm::normalize(-axes[0] - tx * axes[2]), eye, 0.0),
              plane(glm::normalize(axes[1] - ty * axes[2]), eye, 0.0),
              plane(glm::normalize(-axes[1] - ty * axes[2]), eye, 0.0)};
    eye_ = glm::vec3(eye);
    // A few roundings of numbers up to the eye's distance.
    slack_ = static_cast<float>(1e-6 * (1.0 + glm::length(eye)));
    focal_ = static_cast<float>(0.5 * size.y / ty / std::max(pixel_size, 1e-6f));
  }

  Side classify(const glm::vec3& center, float radius) const {
    const float r = radius + slack_;
    float least = forward_.distance(center) - near_;
    for (const Plane& side : sides_) least = std::min(least, side.distance(center));
    return least < -r ? Side::outside : least > r ? Side::inside : Side::crossing;
  }

  /// Projected area below the pixel's. The ellipse to which a sphere of radius s at depth z and
  /// distance d projects has the area pi f^2 s^2 sqrt(d^2 - s^2) / (z^2 - s^2)^(3/2); compared
  /// squared, so there is neither a root nor a division.
  bool small(const glm::vec3& center, float half) const {
    const float z = forward_.distance(center);
    if (!(z > kSqrt3 * half + near_ + slack_)) return false;
    const glm::vec3 from_eye = center - eye_;
    const float s2 = kSilhouette * half * half;
    const float a = glm::dot(from_eye, from_eye) - s2, b = z * z - s2;
    const float disc = kPi * focal_ * focal_ * s2;
    return disc * disc * a < b * b * b;
  }

  /// False if `small` is false for every node of this size: with d >= z, a projected area is at
  /// least pi f^2 s^2 / z^2, and no depth is greater than that of the cube's farthest corner.
  bool any_small(float half) const {
    const float z = std::max(forward_.distance(glm::vec3(0.5f)) + 0.5f * kSqrt3 + slack_, 0.0f);
    return kPi * focal_ * focal_ * kSilhouette * half * half < z * z;
  }

  static constexpr float kSqrt3 = 1.7320508f;

 private:
  static constexpr float kPi = 3.1415927f;
  static constexpr float kSilhouette = 6.0f / kPi;

  static Plane plane(const glm::dvec3& normal, const glm::dvec3& eye, double shift) {
    return {glm::vec3(normal), static_cast<float>(shift - glm::dot(normal, eye))};
  }

  Plane forward_{};
  std::array<Plane, 4> sides_{};
  glm::vec3 eye_{};
  float near_ = 0.0f, slack_ = 0.0f, focal_ = 1.0f;
};

}  // namespace

CutStats VoxelCut::run(const Svo& svo, const Camera& camera, glm::ivec2 size, float pixel_size) {
  emitted_ = 0;
  CutStats stats;
  if (svo.node_count() == 0) return stats;

  const View view(svo.cube, camera, size, pixel_size);
  const float edge = static_cast<float>(svo.cube.edge);
  if (nodes_.size() < svo.leaf_count()) nodes_.resize(svo.leaf_count());
  CutNode* out = nodes_.data();
  const auto emit = [&out, edge](const Item& item, float half) {
    *out++ = {item.node, item.center * edge, half * edge};
  };

  crossing_.assign(1, {0, glm::vec3(0.5f)});
  std::size_t inside_count = 0;
  float half = 0.5f;
  for (int level = 0; level <= svo.depth; ++level, half *= 0.5f) {
    const bool leaves = level == svo.depth, above_leaves = level + 1 == svo.depth;
    if (!leaves && !above_leaves && next_inside_.size() < svo.node_count(level + 1)) {
      next_inside_.resize(svo.node_count(level + 1));
    }
    const bool may_be_small = view.any_small(half);
    next_crossing_.clear();
    Item* inside = next_inside_.data();
    const float quarter = 0.5f * half;
    std::array<glm::vec3, 8> octants;
    for (unsigned c = 0; c < 8; ++c) {
      octants[c] = quarter * glm::vec3(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1);
    }
    const auto for_each_child = [&](const Item& item, const auto& visit) {
      std::uint32_t child = svo.first_child[item.node];
      for (unsigned mask = svo.masks[item.node]; mask != 0; mask &= mask - 1) {
        visit(
            Item{child++, item.center + octants[static_cast<std::size_t>(std::countr_zero(mask))]});
      }
    };
    const auto descend_inside = [&](const Item& item) {
      if (above_leaves) {
        // Most nodes are leaves inside the frustum: those are emitted straight from their parents.
        const CutNode* before = out;
        for_each_child(item, [&](const Item& child) { emit(child, quarter); });
        stats.visited += static_cast<std::uint32_t>(out - before);
      } else {
        for_each_child(item, [&](const Item& child) { *inside++ = child; });
      }
    };

    stats.visited += static_cast<std::uint32_t>(crossing_.size() + inside_count);
    for (const Item& item : crossing_) {
      const Side side = view.classify(item.center, View::kSqrt3 * half);
      if (side == Side::outside) continue;
      if (leaves || (may_be_small && view.small(item.center, half))) {
        emit(item, half);
      } else if (side == Side::inside) {
        descend_inside(item);
      } else {
        for_each_child(item, [&](const Item& child) { next_crossing_.push_back(child); });
      }
    }
    for (std::size_t i = 0; i < inside_count; ++i) {
      const Item& item = inside_[i];
      if (may_be_small && view.small(item.center, half)) {
        emit(item, half);
      } else {
        descend_inside(item);
      }
    }
    inside_count = static_cast<std::size_t>(inside - next_inside_.data());
    inside_.swap(next_inside_);
    crossing_.swap(next_crossing_);
  }
  emitted_ = static_cast<std::size_t>(out - nodes_.data());
  stats.emitted = static_cast<std::uint32_t>(emitted_);
  return stats;
}

}  // namespace pointreel
