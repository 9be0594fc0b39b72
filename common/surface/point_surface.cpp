#include "common/surface/point_surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "common/base/for_each.h"
#include "common/octree/morton.h"
#include "common/surface/algebraic_sphere.h"
#include "common/surface/cells.h"
#include "pointreel/cpu.h"

namespace pointreel {
namespace {

/// Few enough that a group's candidates are near most of its points, and enough that finding them
/// pays.
constexpr double kPointsPerCell = 3.0;
/// The cosine of the largest angle between the surface's normal and those of its points.
constexpr float kLeastCosine = 0.3f;
/// How many points may be near a group; beyond, a part of them is left out.
constexpr std::size_t kMostCandidates = 4096;
/// Groups that one call of an executor works on.
constexpr std::size_t kGroupsPerTask = 256;

constexpr std::size_t kLanes = 8;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
using LaneMask = std::int32_t __attribute__((vector_size(kLanes * sizeof(float))));

/// Some points, one in each lane. Lanes without a point have a normal of zero, so that they never
/// count.
struct alignas(sizeof(Lanes)) Row {
  Lanes x, y, z, nx, ny, nz;
};

/// Where the surface is evaluated.
struct Place {
  glm::vec3 position, normal;
  float radius;
};

[[gnu::always_inline]] inline float sum_of(const Lanes& v) {
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

/// The sums over the points within the radius whose normals agree with that of the place.
[[gnu::always_inline]] inline SphereSums sums(std::span<const Row> rows, const Place& at) {
  const float per_square = 1.0f / (at.radius * at.radius);
  Lanes w{}, px{}, py{}, pz{}, nx{}, ny{}, nz{}, pp{}, pn{};
  for (const Row& row : rows) {
    const Lanes dx = row.x - at.position.x, dy = row.y - at.position.y, dz = row.z - at.position.z;
    const Lanes square = dx * dx + dy * dy + dz * dz;
    const Lanes cosine = row.nx * at.normal.x + row.ny * at.normal.y + row.nz * at.normal.z;
    Lanes weight = 1.0f - square * per_square;
    const LaneMask counts = (weight > 0.0f) & (cosine > kLeastCosine);
    weight = weight * weight;
    weight = weight * weight;
    weight = reinterpret_cast<Lanes>(reinterpret_cast<LaneMask>(weight) & counts);
    w += weight;
    px += weight * dx;
    py += weight * dy;
    pz += weight * dz;
    nx += weight * row.nx;
    ny += weight * row.ny;
    nz += weight * row.nz;
    pp += weight * square;
    pn += weight * (dx * row.nx + dy * row.ny + dz * row.nz);
  }
  SphereSums total;
  total.w = sum_of(w);
  total.p = {sum_of(px), sum_of(py), sum_of(pz)};
  total.n = {sum_of(nx), sum_of(ny), sum_of(nz)};
  total.pp = sum_of(pp);
  total.pn = sum_of(pn);
  return total;
}

// Both give the same sums to the bit, because the lanes are the same and nothing is contracted.
#if defined(__x86_64__)
[[gnu::target("avx2")]] SphereSums sums_avx2(std::span<const Row> rows, const Place& at) {
  return sums(rows, at);
}
#endif
SphereSums sums_portable(std::span<const Row> rows, const Place& at) { return sums(rows, at); }

using Summation = SphereSums (*)(std::span<const Row>, const Place&);
Summation summation() {
#if defined(__x86_64__)
  if ((cpu_features() & kCpuAvx2) != 0) return sums_avx2;
#endif
  return sums_portable;
}

}  // namespace

/// Points around a group.
struct PointSurface::Candidates {
  std::vector<Row> rows;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ranges;
};

PointSurface::PointSurface(const PointCloud& cloud) {
  if (cloud.empty()) return;
  SortedIntoCells cells = sort_into_cells(cloud, kPointsPerCell);
  sorted_ = std::move(cells.sorted);
  svo_ = build_svo(sorted_, cells.level);
  blocks_ = node_blocks(svo_);
  offset_ = cloud.origin - svo_.cube.origin - 0.5 * svo_.cube.edge;
  positions_.reserve(cloud.size());
  normals_.reserve(cloud.size());
  for (const KeyIndex& point : sorted_.points) {
    positions_.push_back(glm::vec3(glm::dvec3(cloud.positions[point.index]) + offset_));
    normals_.push_back(cloud.normals[point.index]);
  }
  nodes_.resize(svo_.node_count());
  for (int level = 0; level <= svo_.depth; ++level) {
    const int shift = 3 * (sorted_.levels - level);
    const double edge = svo_.cell_size(level);
    std::uint32_t at = 0;
    for (std::uint32_t node = svo_.level_begin[static_cast<std::size_t>(level)];
         node < svo_.level_begin[static_cast<std::size_t>(level) + 1]; ++node) {
      const std::uint64_t key = sorted_.points[at].key >> shift;
      const glm::dvec3 corner = glm::dvec3(morton_decode(key)) * edge - 0.5 * svo_.cube.edge;
      nodes_[node] = {at, at, 0, glm::vec3(corner), static_cast<float>(edge)};
      while (at < sorted_.points.size() && sorted_.points[at].key >> shift == key) ++at;
      nodes_[node].end = at;
    }
  }
  for (std::uint32_t node = 0; node < svo_.internal_count(); ++node) {
    const auto children = static_cast<std::uint32_t>(std::popcount(svo_.masks[node]));
    for (std::uint32_t i = 0; i < children; ++i) nodes_[svo_.first_child[node] + i].parent = node;
  }
}

std::vector<float> PointSurface::radii_of(double points) const {
  std::vector<float> radii(positions_.size());
  if (nodes_.empty()) return radii;
  const std::uint32_t leaves = svo_.level_begin[static_cast<std::size_t>(svo_.depth)];
  for (std::uint32_t leaf = leaves; leaf < nodes_.size(); ++leaf) {
    std::uint32_t node = leaf;
    double count = 0.0;
    while (true) {
      count = 0.0;
      for (const std::uint32_t near : blocks_[node]) {
        if (near != kNoNode) count += nodes_[near].end - nodes_[near].begin;
      }
      if (count >= points || node == 0) break;
      node = nodes_[node].parent;
    }
    // A plane through the block has about the area of a disc with 1.7 times the edge as radius.
    const double radius = 1.7 * nodes_[node].edge * std::sqrt(points / std::max(count, 1.0));
    std::fill(radii.begin() + nodes_[leaf].begin, radii.begin() + nodes_[leaf].end,
              static_cast<float>(radius));
  }
  return radii;
}

std::vector<PointSurface::Group> PointSurface::groups(std::span<const float> radii) const {
  std::vector<float> largest(nodes_.size(), 0.0f);
  const std::uint32_t leaves = svo_.level_begin[static_cast<std::size_t>(svo_.depth)];
  for (std::uint32_t node = leaves; node < nodes_.size(); ++node) {
    for (std::uint32_t i = nodes_[node].begin; i < nodes_[node].end; ++i) {
      largest[node] = std::max(largest[node], radii[i]);
    }
  }
  for (std::size_t node = nodes_.size(); node-- > 1;) {
    float& parent = largest[nodes_[node].parent];
    parent = std::max(parent, largest[node]);
  }
  // The parent of a group has cells wider than the radius, so that all points within the radius are
  // in the block around it.
  std::vector<Group> found;
  std::vector<std::uint32_t> open = {0};
  while (!open.empty()) {
    const std::uint32_t node = open.back();
    open.pop_back();
    if (node >= leaves || nodes_[node].edge <= largest[node]) {
      if (largest[node] > 0.0f) found.push_back({node, largest[node]});
      continue;
    }
    const auto children = static_cast<std::uint32_t>(std::popcount(svo_.masks[node]));
    for (std::uint32_t i = children; i-- > 0;) open.push_back(svo_.first_child[node] + i);
  }
  return found;
}

void PointSurface::gather(const Group& group, Candidates& into) const {
  const Node& own = nodes_[group.node];
  into.ranges.clear();
  std::size_t count = 0;
  const auto add = [&](std::uint32_t node) {
    const Node& near = nodes_[node];
    // The distance between the two cells.
    const glm::vec3 gap = glm::max(
        glm::max(near.corner - (own.corner + own.edge), own.corner - (near.corner + near.edge)),
        glm::vec3(0.0f));
    if (glm::dot(gap, gap) >= group.radius * group.radius) return;
    into.ranges.emplace_back(near.begin, near.end);
    count += near.end - near.begin;
  };
  if (group.node == 0) {
    add(0);
  } else {
    for (const std::uint32_t near : blocks_[own.parent]) {
      if (near == kNoNode) continue;
      const auto children = static_cast<std::uint32_t>(std::popcount(svo_.masks[near]));
      for (std::uint32_t i = 0; i < children; ++i) add(svo_.first_child[near] + i);
    }
  }
  const std::size_t stride = (count + kMostCandidates - 1) / kMostCandidates;
  into.rows.resize((count / std::max<std::size_t>(stride, 1) + into.ranges.size() + kLanes) /
                   kLanes);
  std::size_t filled = 0;
  for (const auto& [begin, end] : into.ranges) {
    for (std::size_t i = begin; i < end; i += stride) {
      Row& row = into.rows[filled / kLanes];
      const std::size_t lane = filled++ % kLanes;
      row.x[lane] = positions_[i].x;
      row.y[lane] = positions_[i].y;
      row.z[lane] = positions_[i].z;
      row.nx[lane] = normals_[i].x;
      row.ny[lane] = normals_[i].y;
      row.nz[lane] = normals_[i].z;
    }
  }
  into.rows.resize((filled + kLanes - 1) / kLanes);
  for (; filled % kLanes != 0; ++filled) {
    Row& row = into.rows[filled / kLanes];
    const std::size_t lane = filled % kLanes;
    row.x[lane] = row.y[lane] = row.z[lane] = 0.0f;
    row.nx[lane] = row.ny[lane] = row.nz[lane] = 0.0f;
  }
}

void PointSurface::project(const Group& group, std::span<const float> radii, double beta, int steps,
                           Candidates& candidates, std::span<SurfaceSample> samples) const {
  gather(group, candidates);
  const Summation sums_at = summation();
  for (std::uint32_t i = nodes_[group.node].begin; i < nodes_[group.node].end; ++i) {
    if (!(radii[i] > 0.0f)) continue;
    const glm::vec3 start = positions_[i];
    glm::vec3 place = start, normal = normals_[i];
    float weight = 0.0f;
    for (int step = 0; step < steps; ++step) {
      const SphereSums sums = sums_at(candidates.rows, {place, normal, radii[i]});
      weight = static_cast<float>(sums.w);
      const std::optional<AlgebraicSphere> sphere = fit_sphere(sums, beta);
      const std::optional<SurfacePoint> found =
          sphere ? sphere->project(glm::dvec3(start - place)) : std::nullopt;
      const glm::vec3 next = found ? place + glm::vec3(found->position) : start;
      const glm::vec3 way = next - start;
      if (!found || glm::dot(way, way) > radii[i] * radii[i]) {
        place = start;
        weight = 0.0f;
        break;
      }
      place = next;
      normal = glm::vec3(found->normal);
    }
    samples[i] = {glm::vec3(glm::dvec3(place) - offset_), normal, weight};
  }
}

std::vector<SurfaceSample> PointSurface::project(std::span<const float> radii, double beta,
                                                 int steps, const Executor& executor) const {
  std::vector<SurfaceSample> samples(positions_.size());
  if (nodes_.empty()) return samples;
  const std::vector<Group> all = groups(radii);
  const std::size_t tasks = (all.size() + kGroupsPerTask - 1) / kGroupsPerTask;
  for_each(executor, static_cast<int>(tasks), [&](int task) {
    Candidates candidates;
    const std::size_t begin = static_cast<std::size_t>(task) * kGroupsPerTask;
    for (std::size_t i = begin; i < std::min(begin + kGroupsPerTask, all.size()); ++i) {
      project(all[i], radii, beta, steps, candidates, samples);
    }
  });
  return samples;
}

std::vector<float> PointSurface::local_mean(std::span<const float> values,
                                            std::size_t points) const {
  std::vector<double> sums(nodes_.size(), 0.0);
  std::vector<std::uint32_t> counts(nodes_.size(), 0);
  const std::uint32_t leaves =
      nodes_.empty() ? 0 : svo_.level_begin[static_cast<std::size_t>(svo_.depth)];
  for (std::size_t node = nodes_.size(); node-- > 0;) {
    if (node >= leaves) {
      for (std::uint32_t i = nodes_[node].begin; i < nodes_[node].end; ++i) {
        if (values[i] < 0.0f) continue;
        sums[node] += values[i];
        ++counts[node];
      }
    }
    if (node == 0) break;
    sums[nodes_[node].parent] += sums[node];
    counts[nodes_[node].parent] += counts[node];
  }
  std::vector<float> means(positions_.size(), 0.0f);
  for (std::uint32_t leaf = leaves; leaf < nodes_.size(); ++leaf) {
    double sum = 0.0, count = 0.0;
    for (std::uint32_t node = leaf;; node = nodes_[node].parent) {
      sum = count = 0.0;
      for (const std::uint32_t near : blocks_[node]) {
        if (near == kNoNode) continue;
        sum += sums[near];
        count += counts[near];
      }
      if (count >= static_cast<double>(points) || node == 0) break;
    }
    const auto mean = static_cast<float>(count > 0.0 ? sum / count : 0.0);
    std::fill(means.begin() + nodes_[leaf].begin, means.begin() + nodes_[leaf].end, mean);
  }
  return means;
}

}  // namespace pointreel
