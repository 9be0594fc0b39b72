#include "codec/surface/normals.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "codec/core/build.h"
#include "codec/surface/cell_neighbors.h"
#include "codec/surface/cells.h"
#include "codec/surface/openness.h"
#include "common/base/blocks.h"
#include "common/base/median.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

/// The number of points in a cell that the choice of level aims at. A cell and its neighbours then
/// contain about 25.
constexpr double kPointsPerNormalCell = 2.0;
/// If a cell and its neighbours contain fewer points, those of its parent are used instead, up to
/// kMaxCoarser times.
constexpr double kMinPoints = 8;
constexpr int kMaxCoarser = 3;
/// The number of points in a cell of the openness grid: enough that no cell of a surface is empty
/// by chance.
constexpr double kPointsPerOpenCell = 6.0;
/// Fewer cells are not worth a block of their own.
constexpr std::size_t kCellsPerBlock = 2048;

/// Sums over points p: their number, p, and the upper triangle of p p^T.
struct Moments {
  double n = 0.0;
  glm::dvec3 p{0.0};
  glm::dvec3 diagonal{0.0};  ///< xx, yy, zz
  glm::dvec3 mixed{0.0};     ///< yz, xz, xy

  void add(const glm::dvec3& v) {
    n += 1.0;
    p += v;
    diagonal += v * v;
    mixed += glm::dvec3(v.y * v.z, v.x * v.z, v.x * v.y);
  }
  void add(const Moments& other) {
    n += other.n;
    p += other.p;
    diagonal += other.diagonal;
    mixed += other.mixed;
  }
};

/// A plane through points, and their variances along the principal axes, in ascending order.
struct Plane {
  glm::dvec3 center{0.0};
  glm::dvec3 normal{0.0};  ///< zero if the points do not span a plane
  glm::dvec3 variances{0.0};
};

/// cos(acos(c) / 3) for c in [-1, 1], computed from roots and divisions only, because the last bit
/// of libm's functions differs between machines. It is the x in [1/2, 1] with 4 x^3 - 3 x = c, that
/// is, with (2 x - 1)^2 (x + 1) = c + 1. Newton's method is applied to x = (1 + sqrt((c + 1) / (x +
/// 1))) / 2, which has no double root that would slow it down.
double cosine_of_third(double c) {
  double x = 0.75;
  for (int step = 0; step < 5; ++step) {
    const double r = std::sqrt((1.0 + c) / (1.0 + x));
    x -= (x - 0.5 - 0.5 * r) / (1.0 + 0.25 * r / (1.0 + x));
  }
  return std::clamp(x, 0.5, 1.0);
}

/// Computes the eigenvalues in closed form (O. K. Smith, "Eigenvalues of a symmetric 3x3 matrix",
/// CACM 4(4), 1961). The normal is the longest cross product of two rows of the matrix from whose
/// diagonal the smallest eigenvalue is subtracted.
Plane fit_plane(const Moments& sums) {
  Plane plane;
  if (sums.n < 1.0) return plane;
  plane.center = sums.p / sums.n;
  const glm::dvec3 c = plane.center;
  glm::dvec3 diagonal = sums.diagonal / sums.n - c * c;
  glm::dvec3 mixed = sums.mixed / sums.n - glm::dvec3(c.y * c.z, c.x * c.z, c.x * c.y);
  const double scale = diagonal.x + diagonal.y + diagonal.z;
  // Below this share, the difference above consists of rounding errors.
  if (!(scale > 1e-14 * (sums.diagonal.x + sums.diagonal.y + sums.diagonal.z) / sums.n)) {
    return plane;
  }
  diagonal /= scale;
  mixed /= scale;
  const double mean = 1.0 / 3.0;
  const glm::dvec3 d = diagonal - mean;
  const double q = glm::dot(d, d) / 6.0 + glm::dot(mixed, mixed) / 3.0;
  const double root = std::sqrt(q);
  const double determinant = d.x * (d.y * d.z - mixed.x * mixed.x) -
                             mixed.z * (mixed.z * d.z - mixed.x * mixed.y) +
                             mixed.y * (mixed.z * mixed.x - d.y * mixed.y);
  const double cosine = root > 0.0 ? std::clamp(0.5 * determinant / (q * root), -1.0, 1.0) : 1.0;
  const double third = cosine_of_third(cosine);
  const double largest = mean + 2.0 * root * third;
  const double smallest = mean - root * (third + std::sqrt(3.0 * (1.0 - third) * (1.0 + third)));
  const double middle = 1.0 - largest - smallest;
  plane.variances = glm::max(scale * glm::dvec3(smallest, middle, largest), 0.0);
  // The points are on a line if the middle variance is within rounding errors or noise.
  if (middle < 1e-4 * largest || middle - smallest < 1e-6) return plane;

  const glm::dvec3 e = diagonal - smallest;
  const glm::dvec3 a(e.x, mixed.z, mixed.y), b(mixed.z, e.y, mixed.x), f(mixed.y, mixed.x, e.z);
  const glm::dvec3 ab = glm::cross(a, b), af = glm::cross(a, f), bf = glm::cross(b, f);
  const double lab = glm::dot(ab, ab), laf = glm::dot(af, af), lbf = glm::dot(bf, bf);
  const double longest = std::max({lab, laf, lbf});
  if (!(longest > 0.0)) return plane;
  plane.normal = (longest == lab ? ab : longest == laf ? af : bf) / std::sqrt(longest);
  return plane;
}

/// The surface in a leaf cell, in single precision, because the loops over neighbours read much of
/// it.
struct CellSurface {
  glm::vec3 center;  ///< of the points that the plane was fitted to, relative to the cube's centre
  glm::vec3 normal;  ///< of unit length, or zero
  float spacing;     ///< of the points; 0 if unknown
};

/// Converts a radius to a finite float > 0, whatever the scale of the coordinates.
float finite_radius(double radius) {
  using Limits = std::numeric_limits<float>;
  return static_cast<float>(std::clamp<double>(radius, Limits::denorm_min(), Limits::max()));
}

class SurfaceEstimate {
 public:
  SurfaceEstimate(const PointCloud& cloud, const Executor& executor)
      : cloud_(cloud), executor_(executor) {
    SortedIntoCells cells = sort_into_cells(cloud, kPointsPerNormalCell, executor_);
    sorted_ = std::move(cells.sorted);
    svo_ = build_svo(sorted_, cells.level, executor_);
    blocks_ = node_blocks(svo_);
    list_neighbors();
    sum_moments();
    fit_cells();
  }

  void orient() {
    const int level = std::min({choose_level(sorted_, kPointsPerOpenCell, Openness::kMaxLevel),
                                svo_.depth, Openness::kMaxLevel});
    const Openness openness(svo_, level);
    const float step = static_cast<float>(openness.cell_size());
    std::vector<float> votes(cells_.size());
    for_each_cell([&](std::size_t i) { votes[i] = vote(openness, step, cells_[i]); });
    // Each cell takes over the votes of its neighbours, so that single wrong votes are outvoted.
    std::vector<float> before;
    for (int round = 0; round < 2; ++round) {
      before = votes;
      for_each_cell([&](std::size_t i) {
        float sum = 0.0f;
        for (const std::uint32_t k : neighbors(i)) {
          sum += before[k] * glm::dot(cells_[i].normal, cells_[k].normal);
        }
        votes[i] = sum;
      });
    }
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (votes[i] < 0.0f) cells_[i].normal = -cells_[i].normal;
    }
  }

  void write_normals(std::vector<glm::vec3>& normals) const {
    normals.resize(cloud_.size());
    const float reach = 1.5f * static_cast<float>(svo_.cell_size(svo_.depth));
    const float per_square = 1.0f / (reach * reach);
    // The cells around a cell, in groups of four for vector instructions. Unused places have no
    // normal and therefore no effect.
    constexpr std::size_t kLanes = 4;
    using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
    struct Group {
      Lanes x{}, y{}, z{}, nx{}, ny{}, nz{};
    };
    for_each_cell([&](std::size_t cell) {
      std::array<Group, 7> around;
      const glm::vec3 own = cells_[cell].normal;
      std::size_t count = 0;
      for (const std::uint32_t k : neighbors(cell)) {
        const CellSurface& other = cells_[k];
        Group& group = around[count / kLanes];
        const std::size_t lane = count % kLanes;
        group.x[lane] = other.center.x;
        group.y[lane] = other.center.y;
        group.z[lane] = other.center.z;
        // A cell on the other side of a thin sheet is ignored: the next one takes its place.
        const bool same_side = glm::dot(other.normal, own) > 0.0f;
        group.nx[lane] = same_side ? other.normal.x : 0.0f;
        group.ny[lane] = same_side ? other.normal.y : 0.0f;
        group.nz[lane] = same_side ? other.normal.z : 0.0f;
        count += same_side ? 1 : 0;
      }
      for (std::size_t i = count; i % kLanes != 0; ++i) {
        Group& group = around[i / kLanes];
        group.nx[i % kLanes] = group.ny[i % kLanes] = group.nz[i % kLanes] = 0.0f;
      }
      const std::size_t groups = (count + kLanes - 1) / kLanes;
      for (std::uint32_t i = leaf_begin_[cell]; i < leaf_begin_[cell + 1]; ++i) {
        const glm::vec3 p = positions_[i];
        Lanes sx{}, sy{}, sz{};
        for (std::size_t g = 0; g < groups; ++g) {
          const Group& group = around[g];
          const Lanes dx = p.x - group.x, dy = p.y - group.y, dz = p.z - group.z;
          Lanes w = 1.0f - (dx * dx + dy * dy + dz * dz) * per_square;
          w = w > 0.0f ? w * w : Lanes{};
          sx += w * group.nx;
          sy += w * group.ny;
          sz += w * group.nz;
        }
        const glm::vec3 sum =
            glm::vec3(sx[0] + sx[1] + (sx[2] + sx[3]), sy[0] + sy[1] + (sy[2] + sy[3]),
                      sz[0] + sz[1] + (sz[2] + sz[3])) +
            own * 1e-3f;
        const float length = glm::length(sum);
        normals[sorted_.points[i].index] = length > 0.0f ? sum / length : glm::vec3(0.0f);
      }
    });
  }

  void write_radii(std::vector<float>& radii) const {
    radii.resize(cloud_.size());
    const float fallback = typical_spacing();
    for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
      const float radius = cells_[cell].spacing > 0.0f ? cells_[cell].spacing : fallback;
      for (std::uint32_t i = leaf_begin_[cell]; i < leaf_begin_[cell + 1]; ++i) {
        radii[sorted_.points[i].index] = radius;
      }
    }
  }

 private:
  /// Lists the neighbours of each leaf without the gaps that its block has.
  void list_neighbors() {
    const std::uint32_t leaves = svo_.level_begin[static_cast<std::size_t>(svo_.depth)];
    const std::uint32_t count = svo_.leaf_count();
    neighbor_begin_.resize(count + 1);
    neighbors_.resize(std::size_t{count} * 27);
    std::uint32_t end = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      neighbor_begin_[i] = end;
      for (const std::uint32_t neighbor : blocks_[leaves + i]) {
        neighbors_[end] = neighbor - leaves;
        end += neighbor != kNoNode ? 1u : 0u;
      }
    }
    neighbor_begin_[count] = end;
  }

  void sum_moments() {
    const std::uint32_t leaves = svo_.level_begin[static_cast<std::size_t>(svo_.depth)];
    moments_.resize(svo_.node_count());
    leaf_begin_.clear();
    const int shift = 3 * (sorted_.levels - svo_.depth);
    const glm::dvec3 offset = cloud_.origin - svo_.cube.origin - 0.5 * svo_.cube.edge;
    std::uint64_t last = ~std::uint64_t{0};
    positions_.resize(sorted_.points.size());
    for (std::uint32_t i = 0; i < sorted_.points.size(); ++i) {
      const KeyIndex& point = sorted_.points[i];
      if (leaf_begin_.empty() || point.key >> shift != last >> shift) leaf_begin_.push_back(i);
      const glm::dvec3 p = glm::dvec3(cloud_.positions[point.index]) + offset;
      positions_[i] = glm::vec3(p);
      // Points of one cell at the finest level are duplicates.
      if (i == 0 || point.key != last) moments_[leaves + leaf_begin_.size() - 1].add(p);
      last = point.key;
    }
    leaf_begin_.push_back(static_cast<std::uint32_t>(sorted_.points.size()));
    parents_.assign(svo_.node_count(), 0);
    for (std::uint32_t node = svo_.internal_count(); node-- > 0;) {
      const auto children = static_cast<std::uint32_t>(std::popcount(svo_.masks[node]));
      for (std::uint32_t c = 0; c < children; ++c) {
        parents_[svo_.first_child[node] + c] = node;
        moments_[node].add(moments_[svo_.first_child[node] + c]);
      }
    }
  }

  void fit_cells() {
    const std::uint32_t leaves = svo_.level_begin[static_cast<std::size_t>(svo_.depth)];
    cells_.resize(svo_.leaf_count());
    for_each_cell([&](std::size_t i) {
      std::uint32_t node = leaves + static_cast<std::uint32_t>(i);
      Plane plane;
      Moments sums;
      for (int coarser = 0; coarser <= kMaxCoarser; ++coarser) {
        sums = Moments{};
        if (coarser == 0) {
          for (const std::uint32_t k : neighbors(i)) sums.add(moments_[leaves + k]);
        } else {
          for (const std::uint32_t neighbor : blocks_[node]) {
            if (neighbor != kNoNode) sums.add(moments_[neighbor]);
          }
        }
        if (sums.n >= kMinPoints || coarser == kMaxCoarser || node == 0) {
          plane = fit_plane(sums);
          if (plane.normal != glm::dvec3(0.0)) break;
        }
        if (node == 0) break;
        node = parents_[node];
      }
      cells_[i] = {glm::vec3(plane.center), glm::vec3(plane.normal), spacing(plane, sums.n)};
    });
  }

  /// The edge of a square that contains one point, in a patch of n points with these variances. A
  /// rectangle with sides a and b has the variances a^2 / 12 and b^2 / 12, and those of a disc of
  /// the same area are nearly the same.
  static float spacing(const Plane& plane, double n) {
    const double area = 12.0 * std::sqrt(plane.variances.y * plane.variances.z);
    const double length = std::sqrt(12.0 * plane.variances.z);
    if (n < 2.0 || !(length > 0.0)) return 0.0f;
    // In a thin patch, at least the spacing of as many points on a line of the same length.
    return finite_radius(std::max(std::sqrt(area / n), length / n));
  }

  float vote(const Openness& openness, float step, const CellSurface& cell) const {
    float sum = 0.0f;
    for (const float distance : {1.0f, 1.5f, 2.0f, 2.5f}) {
      const glm::vec3 offset = cell.normal * (distance * step);
      const glm::vec3 center = cell.center + static_cast<float>(0.5 * svo_.cube.edge);
      sum += static_cast<float>(openness.at(center + offset) - openness.at(center - offset)) /
             distance;
    }
    return sum;
  }

  /// Calls body(cell) for each leaf, possibly in parallel.
  template <class Body>
  void for_each_cell(const Body& body) const {
    for_each_block(executor_, Blocks(executor_, cells_.size(), kCellsPerBlock),
                   [&](std::size_t, std::size_t begin, std::size_t end) {
                     for (std::size_t cell = begin; cell < end; ++cell) body(cell);
                   });
  }

  /// The leaves around a leaf, including itself.
  std::span<const std::uint32_t> neighbors(std::size_t cell) const {
    return {neighbors_.data() + neighbor_begin_[cell],
            neighbors_.data() + neighbor_begin_[cell + 1]};
  }

  float typical_spacing() const {
    std::vector<float> known;
    for (const CellSurface& cell : cells_) {
      if (cell.spacing > 0.0f) known.push_back(cell.spacing);
    }
    if (known.empty()) return finite_radius(0.5 * svo_.cube.edge);
    return median(std::move(known));
  }

  const PointCloud& cloud_;
  const Executor& executor_;
  SortedPoints sorted_;
  Svo svo_;
  std::vector<glm::vec3> positions_;  ///< sorted, relative to the cube's centre
  std::vector<NodeBlock> blocks_;
  std::vector<std::uint32_t> neighbor_begin_;  ///< for each leaf, with one entry more at the end
  std::vector<std::uint32_t> neighbors_;       ///< leaves, numbered from 0
  std::vector<Moments> moments_;               ///< for each node, relative to the cube's centre
  std::vector<std::uint32_t> parents_;         ///< for each node
  std::vector<std::uint32_t> leaf_begin_;      ///< index into sorted_.points, one more at the end
  std::vector<CellSurface> cells_;             ///< for each leaf
};

/// The mean of the normals around a point that has none, if they agree.
std::optional<glm::vec3> mean_normal(const PointCloud& cloud, std::size_t point) {
  constexpr std::size_t kAround = 12;
  constexpr float kAgree = 0.7f;  ///< the length of the mean of their normals
  struct Near {
    float square;
    std::size_t index;
  };
  std::array<Near, kAround> nearest;
  nearest.fill({std::numeric_limits<float>::infinity(), 0});
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3 way = cloud.positions[i] - cloud.positions[point];
    const float square = glm::dot(way, way);
    if (!(square < nearest.back().square) || cloud.normals[i] == glm::vec3(0.0f)) continue;
    const auto at = std::ranges::upper_bound(nearest, square, {}, &Near::square);
    std::move_backward(at, nearest.end() - 1, nearest.end());
    *at = {square, i};
  }
  if (std::isinf(nearest.back().square)) return std::nullopt;
  glm::vec3 sum(0.0f);
  for (const Near& near : nearest) sum += cloud.normals[near.index];
  if (glm::length(sum) < kAgree * kAround) return std::nullopt;
  return glm::normalize(sum);
}

/// Completes the normals of a few points by those around them, which takes a fraction of the time
/// of estimating all. False if there are many, or if normals around one do not agree.
bool complete_few(PointCloud& cloud) {
  constexpr std::size_t kFew = 64;
  std::vector<std::size_t> unknown;
  for (std::size_t i = 0; i < cloud.size() && unknown.size() <= kFew; ++i)
    if (cloud.normals[i] == glm::vec3(0.0f)) unknown.push_back(i);
  if (unknown.size() > kFew) return false;
  std::vector<glm::vec3> found;
  for (const std::size_t i : unknown) {
    const auto normal = mean_normal(cloud, i);
    if (!normal) return false;
    found.push_back(*normal);
  }
  for (std::size_t k = 0; k < unknown.size(); ++k) cloud.normals[unknown[k]] = found[k];
  return true;
}

}  // namespace

void estimate_normals(PointCloud& cloud, const Executor& executor) {
  cloud.normals.clear();
  if (cloud.empty()) return;
  SurfaceEstimate estimate(cloud, executor);
  estimate.orient();
  estimate.write_normals(cloud.normals);
}

void estimate_unknown_radii(PointCloud& cloud) {
  if (std::find(cloud.radii.begin(), cloud.radii.end(), 0.0f) == cloud.radii.end()) return;
  const float largest = *std::max_element(cloud.radii.begin(), cloud.radii.end());
  std::vector<float> estimate;
  SurfaceEstimate(cloud, {}).write_radii(estimate);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.radii[i] == 0.0f) cloud.radii[i] = std::min(estimate[i], largest);
  }
}

void estimate_normals_and_radii(PointCloud& cloud, const Executor& executor) {
  cloud.normals.clear();
  cloud.radii.clear();
  if (cloud.empty()) return;
  SurfaceEstimate estimate(cloud, executor);
  estimate.write_radii(cloud.radii);
  estimate.orient();
  estimate.write_normals(cloud.normals);
}

void complete_normals(PointCloud& cloud, const Executor& executor) {
  const auto lacks = [](const glm::vec3& normal) { return normal == glm::vec3(0.0f); };
  if (!cloud.has_normals()) {
    estimate_normals(cloud, executor);
  } else if (std::ranges::any_of(cloud.normals, lacks)) {
    if (complete_few(cloud)) return;
    std::vector<glm::vec3> given = std::move(cloud.normals);
    estimate_normals(cloud, executor);
    for (std::size_t i = 0; i < given.size(); ++i) {
      if (!lacks(given[i])) cloud.normals[i] = given[i];
    }
  }
}

}  // namespace pointreel
