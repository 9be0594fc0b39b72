#include "client/scene/cut.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>

#include "client/scene/frustum.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

using Side = Frustum::Side;

/// The frustum and the size criterion, with the edge of the octree's cube as the unit.
class View : public Frustum {
 public:
  View(const Cube& cube, const Camera& camera, glm::ivec2 size, float pixel_size)
      : Frustum(camera, size, cube.origin, cube.edge),
        focal_(static_cast<float>(0.5 * size.y / std::tan(0.5 * camera.fov_y) /
                                  std::max(pixel_size, 1e-6f))) {}

  /// Whether the projected area is below the pixel's. The ellipse to which a sphere of radius s at
  /// depth z and distance d projects has the area pi f^2 s^2 sqrt(d^2 - s^2) / (z^2 - s^2)^(3/2);
  /// it is compared squared, which needs neither a root nor a division.
  bool small(const glm::vec3& center, float half) const {
    const float z = depth(center);
    if (!(z > kSqrt3 * half + near() + slack())) return false;
    const glm::vec3 from_eye = center - eye();
    const float s2 = kSilhouette * half * half;
    const float a = glm::dot(from_eye, from_eye) - s2, b = z * z - s2;
    const float disc = kPi * focal_ * focal_ * s2;
    return disc * disc * a < b * b * b;
  }

  /// False if `small` is false for every node of this size: with d >= z, a projected area is at
  /// least pi f^2 s^2 / z^2, and no depth is greater than that of the cube's farthest corner.
  bool any_small(float half) const {
    const float z = std::max(depth(glm::vec3(0.5f)) + 0.5f * kSqrt3 + slack(), 0.0f);
    return kPi * focal_ * focal_ * kSilhouette * half * half < z * z;
  }

  /// True only if `small` is true for every node of this size that is not culled and whose centre
  /// has at least this depth: the area falls with depth, and the centre is no farther from the eye
  /// than the frustum's edge plus the node's radius.
  bool all_small(float half, float z) const {
    const float radius = kSqrt3 * half + 2.0f * slack();
    if (!(z > radius + near())) return false;
    const glm::vec2 off = slope() * z + radius * glm::sqrt(1.0f + slope() * slope());
    const float s2 = kSilhouette * half * half;
    const float a = z * z + glm::dot(off, off) - s2, b = z * z - s2;
    const float disc = kPi * focal_ * focal_ * s2;
    return disc * disc * a < 0.999f * b * b * b;
  }

  static constexpr float kSqrt3 = 1.7320508f;

 private:
  static constexpr float kPi = 3.1415927f;
  static constexpr float kSilhouette = 6.0f / kPi;

  float focal_;
};

typedef std::int32_t Int4 __attribute__((vector_size(16)));
typedef float Float4 __attribute__((vector_size(16)));

/// The octants of each mask of children, in order; 0 behind the last.
constexpr auto kOctants = [] {
  std::array<std::array<std::uint8_t, 8>, 256> octants{};
  for (unsigned mask = 0; mask < 256; ++mask) {
    std::size_t count = 0;
    for (unsigned c = 0; c < 8; ++c) {
      if (mask >> c & 1u) octants[mask][count++] = static_cast<std::uint8_t>(c);
    }
  }
  return octants;
}();

constexpr Int4 kCorners[8] = {{0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {1, 1, 0, 0},
                              {0, 0, 1, 0}, {1, 0, 1, 0}, {0, 1, 1, 0}, {1, 1, 1, 0}};

/// Calls write(k, corner) for the k-th child, and for some k beyond the last. The processor cannot
/// predict how many children a node has, and a wrong prediction costs more than writing elements
/// that the next node's children overwrite.
template <class Write>
inline void write_children(unsigned mask, unsigned count, const Write& write) {
  const std::array<std::uint8_t, 8>& octants = kOctants[mask];
  const auto write_one = [&](int k) { write(k, kCorners[octants[static_cast<std::size_t>(k)]]); };
  write_one(0);
  write_one(1);
  if (count <= 2) return;
  write_one(2);
  write_one(3);
  if (count <= 4) return;
  for (int k = 4; k < 8; ++k) write_one(k);
}

/// How many elements beyond those that count may be written.
constexpr std::size_t kOverwritten = 8;

Int4 load(const std::array<std::int32_t, 4>& lanes) { return std::bit_cast<Int4>(lanes); }

/// Writes a node's place and size. The first three lanes are the centre.
void store(CutNode* out, std::uint32_t node, const Float4& place) {
  static_assert(offsetof(CutNode, half) == offsetof(CutNode, center) + 3 * sizeof(float));
  out->node = node;
  std::memcpy(reinterpret_cast<char*>(out) + offsetof(CutNode, center), &place, sizeof(place));
}

/// How many leaves a node of `level` has.
std::uint32_t leaves_below(const Svo& svo, std::uint32_t node, int level) {
  std::uint32_t begin = node, end = node + 1;
  for (; level < svo.depth; ++level) {
    // Nodes of a level follow each other, and so do their children.
    end = end < svo.internal_count() ? svo.first_child[end] : svo.node_count();
    begin = svo.first_child[begin];
  }
  return end - begin;
}

}  // namespace

int finest_level(const Cube& cube, const Box& bounds, const Camera& camera, glm::ivec2 size,
                 float pixel_size) {
  if (bounds.empty()) return 0;
  const View view(cube, camera, size, pixel_size);
  float nearest = std::numeric_limits<float>::max();
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p(corner & 1 ? bounds.max.x : bounds.min.x,
                       corner & 2 ? bounds.max.y : bounds.min.y,
                       corner & 4 ? bounds.max.z : bounds.min.z);
    nearest = std::min(nearest, view.depth(glm::vec3((p - cube.origin) / cube.edge)));
  }
  int level = 0;
  for (float half = 0.5f; level < kMaxDepth; ++level, half *= 0.5f) {
    if (view.all_small(half, nearest - View::kSqrt3 * half)) break;
  }
  return level;
}

CutStats VoxelCut::run(const Svo& svo, const Camera& camera, glm::ivec2 size, float pixel_size) {
  emitted_ = 0;
  CutStats stats;
  if (svo.node_count() == 0) return stats;

  const View view(svo.cube, camera, size, pixel_size);
  if (nodes_.size() < svo.leaf_count() + kOverwritten)
    nodes_.resize(svo.leaf_count() + kOverwritten);
  CutNode* out = nodes_.data();

  crossing_.assign(1, Item{});
  std::size_t inside_count = 0;
  float half = 0.5f;
  for (int level = 0; level <= svo.depth; ++level, half *= 0.5f) {
    const bool leaves = level == svo.depth, above_leaves = level + 1 == svo.depth;
    if (!leaves && !above_leaves && next_inside_.size() < svo.node_count(level + 1) + kOverwritten)
      next_inside_.resize(svo.node_count(level + 1) + kOverwritten);
    const bool may_be_small = view.any_small(half);
    next_crossing_.clear();
    Item* inside = next_inside_.data();
    // Half the edge of a node on this level, and of its children, in the source's units.
    const float world_half = half * static_cast<float>(svo.cube.edge);
    const float child_half = 0.5f * world_half;

    const auto center = [half](const Item& item) {
      return half * glm::vec3(2 * item[0] + 1, 2 * item[1] + 1, 2 * item[2] + 1);
    };
    const auto emit = [&](const Item& item) {
      const Int4 odd = (2 * load(item) & Int4{-1, -1, -1, 0}) + 1;
      store(out++, static_cast<std::uint32_t>(item[3]),
            __builtin_convertvector(odd, Float4) * world_half);
    };
    const auto descend_inside = [&](const Item& item) {
      const auto node = static_cast<std::uint32_t>(item[3]);
      const unsigned mask = svo.masks[node];
      const auto count = static_cast<unsigned>(std::popcount(mask));
      const std::uint32_t first = svo.first_child[node];
      if (above_leaves) {
        // Most nodes are leaves inside the frustum: those are emitted straight from their parents.
        const Int4 odd = (4 * load(item) & Int4{-1, -1, -1, 0}) + 1;
        write_children(mask, count, [&](int k, const Int4& corner) {
          store(out + k, first + static_cast<std::uint32_t>(k),
                __builtin_convertvector(odd + 2 * corner, Float4) * child_half);
        });
        out += count;
        stats.visited += count;
      } else {
        const Int4 doubled = (2 * load(item) & Int4{-1, -1, -1, 0}) +
                             Int4{0, 0, 0, static_cast<std::int32_t>(first)};
        write_children(mask, count, [&](int k, const Int4& corner) {
          inside[k] = std::bit_cast<Item>(doubled + corner + Int4{0, 0, 0, k});
        });
        inside += count;
      }
    };
    const auto descend_crossing = [&](const Item& item) {
      const auto node = static_cast<std::size_t>(item[3]);
      auto child = static_cast<std::int32_t>(svo.first_child[node]);
      for (unsigned mask = svo.masks[node]; mask != 0; mask &= mask - 1) {
        const int c = std::countr_zero(mask);
        next_crossing_.push_back(
            {2 * item[0] + (c & 1), 2 * item[1] + (c >> 1 & 1), 2 * item[2] + (c >> 2), child++});
      }
    };

    stats.visited += static_cast<std::uint32_t>(crossing_.size() + inside_count);
    for (const Item& item : crossing_) {
      const Side side = view.classify(center(item), View::kSqrt3 * half);
      if (side == Side::outside) {
        stats.out_of_view += leaves_below(svo, static_cast<std::uint32_t>(item[3]), level);
        continue;
      }
      if (leaves || (may_be_small && view.small(center(item), half))) {
        emit(item);
      } else if (side == Side::inside) {
        descend_inside(item);
      } else {
        descend_crossing(item);
      }
    }
    for (std::size_t i = 0; i < inside_count; ++i) {
      const Item& item = inside_[i];
      if (may_be_small && view.small(center(item), half)) {
        emit(item);
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
