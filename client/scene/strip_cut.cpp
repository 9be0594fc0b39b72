#include "client/scene/strip_cut.h"

#include <algorithm>
#include <cmath>

#include "client/scene/frustum.h"

namespace pointreel {
namespace {

/// Ranges that follow one another are joined until they are this long, so that they can be shared
/// out among threads.
constexpr std::uint32_t kLongRange = 4096;

enum class Facing { eye, mixed, away };

/// Which sides of a node's triangles the eye sees.
Facing facing_of(const StripNode& node, const glm::vec3& from_eye, float distance, float radius) {
  if (!(node.cosine > 0.0f) || radius >= distance) return Facing::mixed;
  // The angles of the normals' cone, and of the one in which the sphere is seen.
  const float sine_a = std::sqrt(std::max(1.0f - node.cosine * node.cosine, 0.0f));
  const float sine_b = radius / distance, cosine_b = std::sqrt(1.0f - sine_b * sine_b);
  const float cosine = node.cosine * cosine_b - sine_a * sine_b;  // of their sum
  if (!(cosine > 0.0f)) return Facing::mixed;
  const float sine = sine_a * cosine_b + node.cosine * sine_b;
  const float along = glm::dot(node.axis, from_eye), least = (sine + 1e-5f) * distance;
  return along > least ? Facing::away : along < -least ? Facing::eye : Facing::mixed;
}

}  // namespace

void cut_strips(const SurfelStrips& strips, const StripView& view, StripCut& cut) {
  for (std::vector<StripCut::Range>* ranges : {&cut.facing, &cut.mixed, &cut.turned_away})
    ranges->clear();
  cut.points.clear();
  cut.visited = cut.triangles = cut.backs = cut.out_of_view = cut.below_pixel = 0;
  if (strips.empty()) return;
  const Frustum frustum(view.camera, view.size, view.origin, 1.0);
  // The size of a pixel at depth 1.
  const auto pixel =
      static_cast<float>(2.0 * std::tan(0.5 * view.camera.fov_y) / view.size.y * view.pixel_size);

  const auto append = [](std::vector<StripCut::Range>& ranges, const StripNode& node) {
    if (!ranges.empty() && ranges.back().count < kLongRange &&
        ranges.back().first + ranges.back().count == node.first_index)
      ranges.back().count += node.indices;
    else
      ranges.push_back({node.first_index, node.indices});
  };

  struct Item {
    std::uint32_t node;
    bool inside;    ///< in the frustum
    Facing facing;  ///< mixed: not known
  };
  std::vector<Item> stack{{0, false, Facing::mixed}};
  while (!stack.empty()) {
    auto [index, inside, facing] = stack.back();
    stack.pop_back();
    const StripNode& node = strips.nodes[index];
    ++cut.visited;
    if (node.indices == 0) continue;
    const glm::vec3 from_eye = node.center - frustum.eye();
    const float radius = node.radius + frustum.slack(), distance = glm::length(from_eye);
    if (!inside) {
      const auto side = frustum.classify(node.center, radius);
      if (side == Frustum::Side::outside) {
        cut.out_of_view += node.triangles;
        continue;
      }
      inside = side == Frustum::Side::inside;
    }
    if (facing == Facing::mixed && !view.signs_unknown)
      facing = facing_of(node, from_eye, distance, radius);
    if (2.0f * node.radius <= pixel * (distance - node.radius)) {
      if (facing != Facing::away) cut.points.push_back(index);
      cut.below_pixel += node.triangles;
      continue;
    }
    if (node.children > 0) {
      for (std::uint32_t child = node.children; child-- > 0;)
        stack.push_back({node.first_child + child, inside, facing});
      continue;
    }
    (facing == Facing::away ? cut.backs : cut.triangles) += node.triangles;
    append(facing == Facing::away    ? cut.turned_away
           : facing == Facing::mixed ? cut.mixed
                                     : cut.facing,
           node);
  }
}

}  // namespace pointreel
