#include "datasets_synthetic/surface_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace pointreel {

Result<SurfaceGrid> SurfaceGrid::build(Surface surface) {
  constexpr int kMaxLevels = 10;  // 11 m
  if (surface.blends.empty()) {
    return fail(ErrorCode::argument, "cannot sample a surface without any parts");
  }
  const Box box = bounds(surface);
  const glm::dvec3 extent = box.extent() + 4.0 * kShell;
  const double largest = std::max({extent.x, extent.y, extent.z});
  if (!(largest <= kCell * static_cast<double>(1 << kMaxLevels))) {
    return fail(ErrorCode::limit, "cannot sample a surface larger than 11 m");
  }
  for (const Primitive& primitive : surface.primitives) {
    if (!std::isfinite(distance_to(primitive, box.min).value)) {
      return fail(ErrorCode::argument, "cannot sample a surface with a part that is not finite");
    }
  }
  SurfaceGrid grid(std::move(surface));
  grid.origin_ = box.min - 2.0 * kShell;
  int levels = 0;
  while (kCell * static_cast<double>(1 << levels) < largest) ++levels;
  std::vector<std::uint16_t> all(grid.surface_.blends.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint16_t>(i);
  grid.known_.resize(grid.surface_.primitives.size());
  grid.divide(grid.origin_, {0, 0, 0}, levels, all);
  for (const Cell& cell : grid.cells_) {
    if (cell.blend_count > kMaxBlends) {
      return fail(ErrorCode::limit,
                  fmt::format("cannot sample a surface with more than {} parts within {} mm",
                              kMaxBlends, 1000.0 * kCell));
    }
  }
  grid.make_lookup();
  return grid;
}

// Divides cubes as an octree does. The distance never changes faster than the position, so a cube
// whose centre is further from the shell than from its own corners cannot meet the shell.
void SurfaceGrid::divide(const glm::dvec3& min, const glm::ivec3& first, int level,
                         std::span<const std::uint16_t> candidates) {
  const double edge = kCell * static_cast<double>(1u << level);
  const double reach = 0.5 * std::sqrt(3.0) * edge + kShell;
  const double nearest = blend_values_at(candidates, min + 0.5 * edge);
  if (std::abs(nearest) > reach) return;
  // A blend that is nowhere in reach the nearest one does not affect the distance. A point that
  // moves to the surface may leave the cell by kShell.
  const auto matters = [&](double value) {
    return value <= reach + kShell && value - nearest <= 2.0 * (reach + kShell);
  };
  if (level == 0) {
    const auto first_blend = static_cast<std::uint32_t>(blends_.size());
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (!matters(values_[i])) continue;
      // The nearest come first, so that a search for the smallest distance can stop early.
      const auto value = static_cast<float>(values_[i]);
      std::size_t place = blends_.size();
      blends_.push_back(candidates[i]);
      blend_values_.push_back(value);
      for (; place > first_blend && blend_values_[place - 1] > value; --place) {
        blends_[place] = blends_[place - 1];
        blend_values_[place] = blend_values_[place - 1];
      }
      blends_[place] = candidates[i];
      blend_values_[place] = value;
    }
    cells_.push_back(
        {min, nearest, first_blend, static_cast<std::uint32_t>(blends_.size()) - first_blend});
    coordinates_.push_back(first);
    return;
  }
  std::vector<std::uint16_t> kept;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (matters(values_[i])) kept.push_back(candidates[i]);
  }
  for (int child = 0; child < 8; ++child) {
    const glm::ivec3 step(child & 1, (child >> 1) & 1, child >> 2);
    divide(min + 0.5 * edge * glm::dvec3(step), first + (1 << (level - 1)) * step, level - 1, kept);
  }
}

double SurfaceGrid::blend_values_at(std::span<const std::uint16_t> blends, const glm::dvec3& p) {
  // Blends share primitives, so each primitive is evaluated only once.
  ++evaluation_;
  const auto value = [&](std::uint16_t primitive) {
    Known& known = known_[primitive];
    if (known.evaluation != evaluation_) known = {evaluation_, ray_primitives_[primitive].value(p)};
    return known.value;
  };
  values_.resize(blends.size());
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < blends.size(); ++i) {
    const Blend& blend = surface_.blends[blends[i]];
    const double first = value(blend.first);
    const double second = blend.first == blend.second ? first : value(blend.second);
    const double overlap = blend.radius - std::abs(first - second);
    values_[i] = std::min(first, second);
    if (blend.first != blend.second && overlap > 0.0) {
      values_[i] -= 0.25 * overlap * (overlap / blend.radius);
    }
    nearest = std::min(nearest, values_[i]);
  }
  return nearest;
}

void SurfaceGrid::make_lookup() {
  for (const glm::ivec3& cell : coordinates_) {
    size_ = glm::max(size_, kBlock * (cell / kBlock + 1));
  }
  const glm::ivec3 count = size_ / kBlock;
  blocks_.assign(static_cast<std::size_t>(count.x) * static_cast<std::size_t>(count.y) *
                     static_cast<std::size_t>(count.z),
                 kNone);
  constexpr std::size_t kCells = std::size_t{kBlock} * kBlock * kBlock;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const glm::ivec3 cell = coordinates_[i];
    const glm::ivec3 at = cell / kBlock;
    std::uint32_t& number =
        blocks_[static_cast<std::size_t>(at.x + count.x * (at.y + count.y * at.z))];
    if (number == kNone) {
      number = static_cast<std::uint32_t>(lookup_.size() / kCells);
      lookup_.resize(lookup_.size() + kCells, kNone);
    }
    const glm::ivec3 local = cell % kBlock;
    lookup_[number * kCells +
            static_cast<std::size_t>(local.x + kBlock * (local.y + kBlock * local.z))] =
        static_cast<std::uint32_t>(i);
  }
}

SurfaceDistance SurfaceGrid::distance(const Cell& cell, const glm::dvec3& p) const {
  // Blends share primitives, so each primitive is evaluated only once. Gradients are computed for
  // the deciding blend only.
  std::array<std::uint16_t, 2 * kMaxBlends> primitives;
  std::array<double, 2 * kMaxBlends> values;
  std::size_t count = 0;
  const auto value = [&](std::uint16_t primitive) {
    std::size_t i = 0;
    while (i < count && primitives[i] != primitive) ++i;
    if (i == count) {
      primitives[count] = primitive;
      values[count++] = ray_primitives_[primitive].value(p);
    }
    return values[i];
  };
  const glm::dvec3 off = p - (cell.min + 0.5 * kCell);
  // The micrometre makes up for the single precision of the distances that this is compared with.
  const double moved = std::sqrt(glm::dot(off, off)) + 1e-6;
  const std::span<const std::uint16_t> all = blends(cell);
  const std::span<const float> at_center = blend_values(cell);
  double nearest = std::numeric_limits<double>::infinity();
  const Blend* best = nullptr;
  bool mixed = false, first_is_nearer = true;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (at_center[i] - moved >= nearest) break;  // all that follow are even further away
    const Blend& blend = surface_.blends[all[i]];
    const double first = value(blend.first);
    const double second = blend.first == blend.second ? first : value(blend.second);
    const double overlap =
        blend.first == blend.second ? 0.0 : blend.radius - std::abs(first - second);
    double both = std::min(first, second);
    if (overlap > 0.0) both -= 0.25 * overlap * (overlap / blend.radius);
    if (both < nearest) {
      nearest = both;
      best = &blend;
      mixed = overlap > 0.0;
      first_is_nearer = first <= second;
    }
  }
  const std::uint16_t nearer = first_is_nearer ? best->first : best->second;
  if (!mixed) return {ray_primitives_[nearer].at(p), nearer};
  return {smooth_union(ray_primitives_[best->first].at(p), ray_primitives_[best->second].at(p),
                       best->radius),
          nearer};
}

glm::ivec3 SurfaceGrid::cell_at(const glm::dvec3& p) const {
  return glm::ivec3(glm::floor((p - origin_) / kCell));
}

}  // namespace pointreel
