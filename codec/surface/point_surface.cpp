#include "codec/surface/point_surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "codec/core/morton.h"
#include "codec/surface/algebraic_sphere.h"
#include "codec/surface/cells.h"
#include "codec/surface/place_sums.h"
#include "common/base/for_each.h"

namespace pointreel {
namespace {

/// Of the finest cells in which points are counted. Smaller ones would only make the tree larger.
constexpr double kPointsPerCell = 12.0;
/// Cells are made smaller until no more than this share of the points lies in cells with more than
/// so many points, because part of the points may be denser than the others.
constexpr double kMostCrowded = 0.01;
constexpr std::size_t kCrowd = 100;
/// A cell of a surface has more occupied cells of half its edge within; in scans 2.6 to 4.3 on
/// average. Where there are fewer, the cells hold separate clumps, and are made smaller.
constexpr double kLeastGrowth = 2.3;
/// But not where cells have fewer distinct points on average.
constexpr double kLeastPointsPerCell = 3.0;
/// Nodes with at most so many points are split into rows, wherever the octree's planes are.
constexpr std::uint32_t kPointsPerBundle = 64;
/// The cosine of the largest angle between the surface's normal and those of its points.
constexpr float kLeastCosine = 0.3f;
/// What a point contributes itself is at most 1.
constexpr float kOwnWeight = 1.01f;
/// By what factor more points are selected than the first step needs, because later ones begin
/// elsewhere.
constexpr float kSpareReach = 1.05f;
/// How many rows of a node may be near a group; beyond, a part of them is left out. Each of the
/// nodes around the group has as many, so that a spot with very many points hides no other.
constexpr std::uint32_t kMostRowsOfNode = 128;
/// Groups that one call of an executor works on.
constexpr std::size_t kGroupsPerTask = 64;

bool is_crowded(const SortedPoints& sorted, int level) {
  const int shift = 3 * (sorted.levels - level);
  const std::vector<KeyIndex>& points = sorted.points;
  std::size_t crowded = 0;
  for (std::size_t first = 0; first < points.size();) {
    std::size_t end = first + 1;
    while (end < points.size() && points[end].key >> shift == points[first].key >> shift) ++end;
    if (end - first > kCrowd) crowded += end - first;
    first = end;
  }
  return static_cast<double>(crowded) > kMostCrowded * static_cast<double>(points.size());
}

std::span<const std::uint32_t> points_of(const PointRow& row) {
  return std::span(row.points).first(row.count);
}

/// From a point of a row to the nearest other one, along `normal`. 0 if there is no other one.
float step_to_neighbor(const PointRow& row, std::size_t lane, const glm::vec3& normal) {
  float nearest = std::numeric_limits<float>::infinity(), step = 0.0f;
  for (std::size_t other = 0; other < row.count; ++other) {
    const glm::vec3 way(row.x[other] - row.x[lane], row.y[other] - row.y[lane],
                        row.z[other] - row.z[lane]);
    const float square = glm::dot(way, way);
    if (other == lane || square >= nearest) continue;
    nearest = square;
    step = glm::dot(way, normal);
  }
  return step;
}

/// The nearest of the points that are `near`, no further away than the root of `square`, and on the
/// side of the patch's normal.
void find_neighbors(std::span<const PointNormal> points, std::span<const std::uint32_t> near,
                    std::uint32_t point, float square, SurfacePatch& patch) {
  std::array<float, SurfacePatch::kMostNeighbors> squares;
  for (const std::uint32_t other : near) {
    const glm::vec3 way = points[other].position - points[point].position;
    const float length = glm::dot(way, way);
    const bool is_full = patch.neighbor_count == SurfacePatch::kMostNeighbors;
    if (other == point || length > square || (is_full && length >= squares.back()) ||
        glm::dot(points[other].normal, patch.normal) < kLeastCosine)
      continue;
    std::size_t at = is_full ? SurfacePatch::kMostNeighbors - 1 : patch.neighbor_count++;
    for (; at > 0 && squares[at - 1] > length; --at) {
      squares[at] = squares[at - 1];
      patch.neighbors[at] = patch.neighbors[at - 1];
    }
    squares[at] = length;
    patch.neighbors[at] = other;
  }
}

/// Whether the cells show the shape of what is in them.
bool shows_shape(const SortedPoints& sorted, int level) {
  const auto at = static_cast<std::size_t>(level);
  const double cells = sorted.occupied[at];
  return level == sorted.levels || sorted.occupied[at + 1] >= kLeastGrowth * cells ||
         sorted.occupied.back() < kLeastPointsPerCell * cells;
}

/// The level of cells small enough for the densest parts and for clumps. Where many points are
/// equal, none is, and then it is `level`.
int level_for_details(const SortedPoints& sorted, int level) {
  for (int finer = level; finer <= sorted.levels; ++finer) {
    if (shows_shape(sorted, finer) && !is_crowded(sorted, finer)) return finer;
  }
  return level;
}

}  // namespace

/// What is near a group, and memory that is used again for the next one.
struct PointSurface::Nearby {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ranges;
  std::vector<std::uint32_t> rows;
  std::vector<std::uint32_t> points;  ///< the first `near` of them
  std::size_t near = 0;
};

/// The points of a row as places of the surface.
struct PointSurface::RowPlaces {
  const PointRow& row;
  Places places;
  Lanes start_x{}, start_y{}, start_z{}, radius{}, square{};
  LaneMask wanted{};
  float reach = 0.0f;  ///< of the ball around the row whose points are known to be near

  RowPlaces(const PointRow& points, std::span<const PointNormal> all, std::span<const float> radii,
            float least_cosine, std::span<const glm::vec3> normals = {})
      : row(points) {
    for (std::size_t lane = 0; lane < row.count; ++lane) {
      const std::uint32_t i = row.points[lane];
      const glm::vec3& position = all[i].position;
      const glm::vec3& normal = normals.empty() ? all[i].normal : normals[i];
      start_x[lane] = position.x;
      start_y[lane] = position.y;
      start_z[lane] = position.z;
      places.nx[lane] = normal.x;
      places.ny[lane] = normal.y;
      places.nz[lane] = normal.z;
      radius[lane] = radii[i];
      wanted[lane] = radii[i] > 0.0f ? -1 : 0;
    }
    square = radius * radius;
    places.per_square = 1.0f / (wanted ? square : Lanes{} + 1.0f);
    places.least_cosine = least_cosine;
    places.x = start_x;
    places.y = start_y;
    places.z = start_z;
  }

  /// Finds the points around the places of these lanes, unless they are known.
  void look_around(std::span<const PointRow> rows, const LaneMask& lanes, Nearby& nearby) {
    float needed = 0.0f;
    for (std::size_t lane = 0; lane < row.count; ++lane) {
      if (!lanes[lane]) continue;
      const glm::vec3 place(places.x[lane], places.y[lane], places.z[lane]);
      needed = std::max(needed, glm::distance(row.center, place) + radius[lane]);
    }
    if (needed <= reach) return;
    reach = needed * kSpareReach;
    nearby.near = select_points(rows, nearby.rows, row.center, reach, nearby.points);
  }

  /// The nearest places of the spheres that are fitted around the places, in the coordinates of
  /// the points. Those further away from the points than the radius do not count.
  PlacesFound step(const PlaceSums& sums, double beta) const {
    PlacesFound found = project_onto_spheres(sums, static_cast<float>(beta), start_x - places.x,
                                             start_y - places.y, start_z - places.z);
    found.x += places.x;
    found.y += places.y;
    found.z += places.z;
    const Lanes x = found.x - start_x, y = found.y - start_y, z = found.z - start_z;
    found.found &= wanted & (x * x + y * y + z * z <= square);
    return found;
  }
};

PointSurface::PointSurface(const PointCloud& cloud, const Executor& executor) {
  if (cloud.empty()) return;
  SortedIntoCells cells = sort_into_cells(cloud, kPointsPerCell, executor);
  sorted_ = std::move(cells.sorted);
  svo_ = build_svo(sorted_, level_for_details(sorted_, cells.level), executor);
  blocks_ = node_blocks(svo_);
  offset_ = cloud.origin - svo_.cube.origin - 0.5 * svo_.cube.edge;
  points_.reserve(cloud.size());
  for (const KeyIndex& point : sorted_.points) {
    points_.push_back({glm::vec3(glm::dvec3(cloud.positions[point.index]) + offset_),
                       cloud.normals[point.index]});
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
    for (std::uint32_t i = 0; i < child_count(node); ++i)
      nodes_[svo_.first_child[node] + i].parent = node;
  }
  make_rows();
}

std::uint32_t PointSurface::child_count(std::uint32_t node) const {
  return node < svo_.internal_count() ? static_cast<std::uint32_t>(std::popcount(svo_.masks[node]))
                                      : 0;
}

void PointSurface::make_rows() {
  rows_.reserve(points_.size() / kLanes * 5 / 4 + 1);
  // In the order of the points, so that the rows of every node are consecutive.
  std::vector<std::uint32_t> open = {0};
  while (!open.empty()) {
    const std::uint32_t index = open.back();
    open.pop_back();
    Node& node = nodes_[index];
    const std::uint32_t children = child_count(index);
    if (node.end - node.begin > kPointsPerBundle && children > 0) {
      for (std::uint32_t i = children; i-- > 0;) open.push_back(svo_.first_child[index] + i);
      continue;
    }
    node.first_row = static_cast<std::uint32_t>(rows_.size());
    std::vector<std::uint32_t> points(node.end - node.begin);
    std::iota(points.begin(), points.end(), node.begin);
    append_rows(points_, points, rows_);
    node.end_row = static_cast<std::uint32_t>(rows_.size());
  }
  const auto is_bundle = [](const Node& node) { return node.end_row > node.first_row; };
  for (std::uint32_t index = svo_.internal_count(); index-- > 0;) {
    Node& node = nodes_[index];
    const std::uint32_t first = svo_.first_child[index], last = first + child_count(index) - 1;
    if (is_bundle(node) || !is_bundle(nodes_[first])) continue;
    node.first_row = nodes_[first].first_row;
    node.end_row = nodes_[last].end_row;
  }
  for (std::uint32_t index = 1; index < nodes_.size(); ++index) {
    Node& node = nodes_[index];
    if (is_bundle(node)) continue;  // or above one
    node.first_row = nodes_[node.parent].first_row;
    node.end_row = nodes_[node.parent].end_row;
  }
}

/// Calls `has_enough(node)` down the tree as long as it returns true, and `done(begin, end, node)`
/// for the points below the last node that had enough. The root counts as having enough.
template <class Enough, class Done>
void PointSurface::for_smallest_blocks(const Enough& has_enough, const Done& done) const {
  if (nodes_.empty()) return;
  has_enough(0);
  std::vector<std::uint32_t> open = {0};
  while (!open.empty()) {
    const std::uint32_t node = open.back();
    open.pop_back();
    const std::uint32_t children = child_count(node);
    if (children == 0) done(nodes_[node].begin, nodes_[node].end, node);
    for (std::uint32_t i = 0; i < children; ++i) {
      const std::uint32_t child = svo_.first_child[node] + i;
      if (has_enough(child)) {
        open.push_back(child);
      } else {
        done(nodes_[child].begin, nodes_[child].end, node);
      }
    }
  }
}

std::vector<float> PointSurface::radii_of(double points) const {
  std::vector<float> radii(points_.size());
  std::vector<float> radius(nodes_.size());
  for_smallest_blocks(
      [&](std::uint32_t node) {
        std::size_t count = 0;
        for (const std::uint32_t near : blocks_[node]) {
          if (near != kNoNode) count += nodes_[near].end - nodes_[near].begin;
        }
        // A plane through the block has about the area of a disc with 1.7 times the edge as radius.
        radius[node] = static_cast<float>(1.7 * nodes_[node].edge *
                                          std::sqrt(points / static_cast<double>(count)));
        return static_cast<double>(count) >= points;
      },
      [&](std::uint32_t begin, std::uint32_t end, std::uint32_t node) {
        std::fill(radii.begin() + begin, radii.begin() + end, radius[node]);
      });
  return radii;
}

std::vector<PointSurface::Group> PointSurface::groups(std::span<const float> radii) const {
  std::vector<float> largest(nodes_.size(), 0.0f);
  for (std::uint32_t node = svo_.level_begin[static_cast<std::size_t>(svo_.depth)];
       node < nodes_.size(); ++node) {
    for (std::uint32_t i = nodes_[node].begin; i < nodes_[node].end; ++i) {
      largest[node] = std::max(largest[node], radii[i]);
    }
  }
  for (std::size_t node = nodes_.size(); node-- > 1;) {
    float& parent = largest[nodes_[node].parent];
    parent = std::max(parent, largest[node]);
  }
  // A group consists of whole rows.
  std::vector<Group> found;
  std::vector<std::uint32_t> open = {0};
  while (!open.empty()) {
    const std::uint32_t index = open.back();
    open.pop_back();
    const Node& node = nodes_[index];
    const bool splits = node.end - node.begin > kPointsPerBundle && index < svo_.internal_count();
    if (!splits || node.edge <= largest[index]) {
      if (largest[index] > 0.0f) found.push_back({index, largest[index]});
      continue;
    }
    for (std::uint32_t i = child_count(index); i-- > 0;)
      open.push_back(svo_.first_child[index] + i);
  }
  return found;
}

void PointSurface::gather(const Group& group, Nearby& nearby) const {
  // The block around a node with an edge of at least the radius holds all points within it.
  std::uint32_t middle = group.node;
  while (middle != 0 && nodes_[middle].edge < group.radius) middle = nodes_[middle].parent;
  nearby.ranges.clear();
  for (const std::uint32_t near : blocks_[middle]) {
    if (near != kNoNode) nearby.ranges.emplace_back(nodes_[near].first_row, nodes_[near].end_row);
  }
  // Several nodes may share rows, and each row counts once.
  std::sort(nearby.ranges.begin(), nearby.ranges.end());
  nearby.rows.clear();
  const Node& own = nodes_[group.node];
  const float half = 0.5f * own.edge;
  const glm::vec3 center = own.corner + half;
  std::uint32_t next = 0;
  for (const auto& [first, end] : nearby.ranges) {
    const std::uint32_t stride = (end - first) / kMostRowsOfNode + 1;
    for (std::uint32_t r = std::max(first, next); r < end; r += stride) {
      const PointRow& row = rows_[r];
      const glm::vec3 gap = glm::max(glm::abs(row.center - center) - half, glm::vec3(0.0f));
      const float reach = group.radius + row.radius;
      if (glm::dot(gap, gap) < reach * reach) nearby.rows.push_back(r);
    }
    next = std::max(next, end);
  }
}

/// Calls `work(row, nearby)` for the points with a radius of one in `one_in` rows, after gathering
/// what is near. Where few points have one, they share rows of their own.
template <class Work>
void PointSurface::for_each_row(std::span<const float> radii, std::uint32_t one_in,
                                const Executor& executor, const Work& work) const {
  if (nodes_.empty()) return;
  const std::vector<Group> all = groups(radii);
  const std::size_t tasks = (all.size() + kGroupsPerTask - 1) / kGroupsPerTask;
  for_each(executor, static_cast<int>(tasks), [&](int task) {
    Nearby nearby;
    const std::size_t begin = static_cast<std::size_t>(task) * kGroupsPerTask;
    std::vector<std::uint32_t> wanted;
    std::vector<PointRow> rows;
    for (std::size_t i = begin; i < std::min(begin + kGroupsPerTask, all.size()); ++i) {
      const Node& node = nodes_[all[i].node];
      const std::uint32_t first = (node.first_row + one_in - 1) / one_in * one_in;
      if (first >= node.end_row) continue;
      gather(all[i], nearby);
      rows.clear();
      wanted.clear();
      for (std::uint32_t row = first; row < node.end_row; row += one_in) {
        rows.push_back(rows_[row]);
        for (const std::uint32_t point : points_of(rows_[row]))
          if (radii[point] > 0.0f) wanted.push_back(point);
      }
      if (2 * wanted.size() < kLanes * rows.size()) {
        rows.clear();
        append_rows(points_, wanted, rows);
      }
      for (const PointRow& row : rows) work(row, nearby);
    }
  });
}

std::vector<SurfaceEvidence> PointSurface::measure(std::span<const float> radii, double beta,
                                                   std::uint32_t one_in,
                                                   const Executor& executor) const {
  std::vector<SurfaceEvidence> evidence(points_.size());
  for_each_row(radii, one_in, executor, [&](const PointRow& row, Nearby& nearby) {
    RowPlaces at(row, points_, radii, kLeastCosine);
    at.look_around(rows_, at.wanted, nearby);
    PlaceMoments moments;
    const PlaceSums sums =
        sum_around(points_, std::span(nearby.points).first(nearby.near), at.places, &moments);
    const PlacesFound found = at.step(sums, beta);
    for (std::size_t lane = 0; lane < row.count; ++lane) {
      if (!found.found[lane]) continue;
      const glm::vec3 way(found.x[lane] - at.start_x[lane], found.y[lane] - at.start_y[lane],
                          found.z[lane] - at.start_z[lane]);
      const glm::dvec3 normal(found.nx[lane], found.ny[lane], found.nz[lane]);
      const double extent =
          SecondMoments(moments, lane).least_along(normal) / (sums.w[lane] * at.square[lane]);
      const float step = step_to_neighbor(row, lane, glm::vec3(normal));
      evidence[row.points[lane]] = {glm::dot(way, way), sums.w[lane], static_cast<float>(extent),
                                    0.5f * step * step};
    }
  });
  return evidence;
}

void PointSurface::fit_normals(std::span<const float> radii, const Executor& executor) {
  std::vector<glm::vec3> normals(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) normals[i] = points_[i].normal;
  for_each_row(radii, 1, executor, [&](const PointRow& row, Nearby& nearby) {
    RowPlaces at(row, points_, radii, 0.0f);
    at.look_around(rows_, at.wanted, nearby);
    PlaceMoments moments;
    const PlaceSums sums =
        sum_around(points_, std::span(nearby.points).first(nearby.near), at.places, &moments);
    for (std::size_t lane = 0; lane < row.count; ++lane) {
      if (!at.wanted[lane] || !(sums.w[lane] > 0.0f)) continue;
      const SphereSums s = sums.at(lane);
      const std::optional<glm::dvec3> normal =
          SecondMoments(moments, lane).around(s.p, s.w).least_axis(s.n);
      if (normal) normals[row.points[lane]] = glm::vec3(*normal);
    }
  });
  for (std::size_t i = 0; i < points_.size(); ++i) points_[i].normal = normals[i];
}

std::vector<SurfaceSample> PointSurface::project(std::span<const float> radii, double beta,
                                                 int steps, const Executor& executor,
                                                 std::span<const glm::vec3> normals) const {
  std::vector<SurfaceSample> samples(points_.size());
  for_each_row(radii, 1, executor, [&](const PointRow& row, Nearby& nearby) {
    RowPlaces at(row, points_, radii, kLeastCosine, normals);
    LaneMask alive = at.wanted;
    PlaceSums sums;
    for (int step = 0; step < steps; ++step) {
      at.look_around(rows_, alive, nearby);
      sums = sum_around(points_, std::span(nearby.points).first(nearby.near), at.places);
      const PlacesFound found = at.step(sums, beta);
      alive &= found.found;
      at.places.x = alive ? found.x : at.start_x;
      at.places.y = alive ? found.y : at.start_y;
      at.places.z = alive ? found.z : at.start_z;
      at.places.nx = alive ? found.nx : at.places.nx;
      at.places.ny = alive ? found.ny : at.places.ny;
      at.places.nz = alive ? found.nz : at.places.nz;
    }
    for (std::size_t lane = 0; lane < row.count; ++lane) {
      if (!at.wanted[lane]) continue;
      const glm::dvec3 place(at.places.x[lane], at.places.y[lane], at.places.z[lane]);
      samples[row.points[lane]] = {
          glm::vec3(place - offset_),
          glm::vec3(at.places.nx[lane], at.places.ny[lane], at.places.nz[lane]),
          alive[lane] ? sums.w[lane] : 0.0f};
    }
  });
  return samples;
}

void PointSurface::fit_patches(std::span<const float> radii, double beta,
                               std::span<const std::uint32_t> slots,
                               std::span<SurfacePatch> patches, const Executor& executor) const {
  for_each_row(radii, 1, executor, [&](const PointRow& row, Nearby& nearby) {
    RowPlaces at(row, points_, radii, kLeastCosine);
    at.look_around(rows_, at.wanted, nearby);
    const std::span near = std::span(nearby.points).first(nearby.near);
    const PlaceSums sums = sum_around(points_, near, at.places);
    const PlacesFound found = at.step(sums, beta);
    for (std::size_t lane = 0; lane < row.count; ++lane) {
      if (!at.wanted[lane]) continue;
      const std::uint32_t point = row.points[lane];
      SurfacePatch& patch = patches[slots[point]];
      patch = {};
      const auto sphere = fit_sphere(sums.at(lane), beta);
      // A point alone fits any surface.
      if (!found.found[lane] || !sphere || !(sums.w[lane] > kOwnWeight)) continue;
      const glm::dvec3 place(found.x[lane], found.y[lane], found.z[lane]);
      patch.position = glm::vec3(place - offset_);
      patch.normal = glm::vec3(found.nx[lane], found.ny[lane], found.nz[lane]);
      const glm::dvec3 gradient =
          sphere->u + 2.0 * sphere->u4 * (place - glm::dvec3(points_[point].position));
      const double slope = glm::length(gradient);
      patch.curvature = slope > 0.0 ? static_cast<float>(2.0 * sphere->u4 / slope) : 0.0f;
      find_neighbors(points_, near, point, at.square[lane], patch);
    }
  });
}

std::vector<glm::vec3> PointSurface::weighted_means(std::span<const float> radii,
                                                    std::span<const glm::vec3> values,
                                                    const Executor& executor,
                                                    std::span<const glm::vec3> normals) const {
  std::vector<glm::vec3> means(values.begin(), values.end());
  for_each_row(radii, 1, executor, [&](const PointRow& row, Nearby& nearby) {
    RowPlaces at(row, points_, radii, 0.0f, normals);
    at.look_around(rows_, at.wanted, nearby);
    const Places& places = at.places;
    Lanes w{}, x{}, y{}, z{};
    for (const std::uint32_t near : std::span(nearby.points).first(nearby.near)) {
      const auto& [p, n] = points_[near];
      const Lanes dx = p.x - places.x, dy = p.y - places.y, dz = p.z - places.z;
      const Lanes cosine = n.x * places.nx + n.y * places.ny + n.z * places.nz;
      const Lanes left = 1.0f - (dx * dx + dy * dy + dz * dz) * places.per_square;
      const Lanes squared = left * left;
      const Lanes weight = ((left > 0.0f) & (cosine > 0.0f)) ? squared * squared * cosine : Lanes{};
      w += weight;
      x += weight * values[near].x;
      y += weight * values[near].y;
      z += weight * values[near].z;
    }
    for (std::size_t lane = 0; lane < row.count; ++lane) {
      if (at.wanted[lane] && w[lane] > 0.0f)
        means[row.points[lane]] = glm::vec3(x[lane], y[lane], z[lane]) / w[lane];
    }
  });
  return means;
}

std::vector<glm::vec3> PointSurface::local_means(std::span<const glm::vec3> values,
                                                 std::size_t points) const {
  struct Sum {
    glm::vec3 total{0.0f};
    float count = 0.0f;
    void add(const Sum& other) {
      total += other.total;
      count += other.count;
    }
  };
  std::vector<Sum> sums(nodes_.size());
  const std::uint32_t leaves =
      nodes_.empty() ? 0 : svo_.level_begin[static_cast<std::size_t>(svo_.depth)];
  for (std::size_t node = nodes_.size(); node-- > 0;) {
    if (node >= leaves) {
      for (std::uint32_t i = nodes_[node].begin; i < nodes_[node].end; ++i) {
        if (values[i].x >= 0.0f) sums[node].add({values[i], 1.0f});
      }
    }
    if (node > 0) sums[nodes_[node].parent].add(sums[node]);
  }
  std::vector<glm::vec3> means(points_.size()), mean_of(nodes_.size(), glm::vec3(0.0f));
  for_smallest_blocks(
      [&](std::uint32_t node) {
        Sum sum;
        for (const std::uint32_t near : blocks_[node]) {
          if (near != kNoNode) sum.add(sums[near]);
        }
        if (sum.count > 0.0f) mean_of[node] = sum.total / sum.count;
        return sum.count >= static_cast<float>(points);
      },
      [&](std::uint32_t begin, std::uint32_t end, std::uint32_t node) {
        std::fill(means.begin() + begin, means.begin() + end, mean_of[node]);
      });
  return means;
}

}  // namespace pointreel
