#include "datasets_synthetic/closest_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <span>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace pointreel {
namespace {

constexpr double kOnSurface = 1e-9;  // largest |value| of a point on the surface
constexpr double kGain = 1e-8;       // no search for a surface that is nearer by less than this
// From deeper inside, and from further away, the search has more starting points.
constexpr double kDeep = 0.004;
constexpr double kFar = 0.02;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double length(const glm::dvec3& v) { return std::sqrt(glm::dot(v, v)); }

/// Two unit vectors at right angles to the unit vector n and to each other.
std::array<glm::dvec3, 2> tangents(const glm::dvec3& n) {
  const glm::dvec3 other = std::abs(n.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 u = glm::cross(n, other);
  const glm::dvec3 unit = u / length(u);
  return {unit, glm::cross(n, unit)};
}

/// The search for the point of a surface that is nearest to p, among the given blends.
class Search {
 public:
  Search(const Surface& surface, std::span<const std::uint16_t> blends, const glm::dvec3& p)
      : surface_(surface), blends_(blends), p_(p) {}

  /// The distance; infinity if it is found early that the distance is above `limit`.
  double run(double limit = kInfinity) {
    const SurfaceDistance here = distance_to(surface_, blends_, p_);
    // The value never changes faster than the position, so no surface is nearer than this.
    least_ = std::abs(here.distance.value);
    if (least_ > limit) return kInfinity;
    outside_ = here.distance.value >= 0.0;
    glm::dvec3 x = p_ - here.distance.value * here.distance.gradient;
    for (int step = 0; step < kSteps; ++step) {
      const Distance at = distance_to(surface_, blends_, x).distance;
      if (std::abs(at.value) < kOnSurface) {
        best_ = length(p_ - x);
        break;
      }
      const double square = glm::dot(at.gradient, at.gradient);
      if (square < kFlat) break;
      x -= at.value / square * at.gradient;
    }
    if (best_ > least_ + kGain) search_blends(best_ < kInfinity ? x : p_);
    return best_ < kInfinity ? best_ : least_;
  }

 private:
  static constexpr int kSteps = 30;
  static constexpr double kFlat = 1e-6;  // a squared gradient that is too small for a direction

  /// The nearest point x on `blend`, which is buried in `hider`.
  struct Foot {
    std::uint16_t blend, hider;
    glm::dvec3 x;
  };

  // From outside, the nearest point is the nearest of those of all blends. From inside, it is that
  // of a blend around p, because everything nearer is inside that blend, unless it is buried in
  // another.
  void search_blends(const glm::dvec3& begin) {
    std::vector<double> values(blends_.size());
    blend_distances(surface_, blends_, p_, values);
    std::vector<std::size_t> order(blends_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&values](std::size_t a, std::size_t b) { return values[a] < values[b]; });
    std::vector<Foot> buried;
    for (const std::size_t i : order) {
      if (values[i] >= best_ - kGain) break;
      const std::uint16_t blend = blends_[i];
      const auto x = nearest_of(blend, i == order.front() ? begin : p_);
      if (!x) continue;
      const double distance = length(p_ - *x);
      if (values[i] < 0.0) least_ = std::max(least_, distance);
      if (distance < best_) {
        const auto hider = outside_ ? std::nullopt : hidden_by(*x);
        if (!hider) {
          best_ = distance;
        } else if (*hider != blend) {
          buried.push_back({blend, *hider, *x});
        }
      }
      if (best_ <= least_ + kGain) return;
    }
    for (const Foot& foot : buried) {
      search_crease({foot.blend, foot.hider, 0}, 2, foot.x);
    }
  }

  Distance value(std::uint16_t number, const glm::dvec3& x) const {
    const Blend& blend = surface_.blends[number];
    const Distance first = distance_to(surface_.primitives[blend.first], x);
    if (blend.first == blend.second) return first;
    return smooth_union(first, distance_to(surface_.primitives[blend.second], x), blend.radius);
  }

  /// The nearest point of one blend.
  std::optional<glm::dvec3> nearest_of(std::uint16_t number, const glm::dvec3& begin) const {
    const Blend& blend = surface_.blends[number];
    bool alone = false;
    auto nearest = nearest_on(number, begin, alone);
    // From inside, the other side of a limb may be as near.
    const bool deep = !outside_ && least_ > kDeep;
    // From further away than the height of a fold, a neighbouring fold may be as near.
    const bool far = least_ > kFar;
    if (blend.first == blend.second || (alone && !deep && !far)) return nearest;
    double best = nearest ? length(p_ - *nearest) : kInfinity;
    const auto try_from = [&](const glm::dvec3& x) {
      const auto other = nearest_on(number, x, alone);
      if (!other || length(p_ - *other) >= best) return;
      best = length(p_ - *other);
      nearest = other;
    };
    for (const std::uint16_t primitive : {blend.first, blend.second}) {
      const Distance to = distance_to(surface_.primitives[primitive], p_);
      // The fillet may lie a quarter of its radius outside the primitive.
      if (std::abs(to.value) - 0.25 * blend.radius >= best - kGain) continue;
      try_from(p_ - to.value * to.gradient);
    }
    for (int axis = 0; deep && axis < 3; ++axis) {
      for (const double way : {-2.0 * least_, 2.0 * least_}) {
        glm::dvec3 x = p_;
        x[axis] += way;
        try_from(x);
      }
    }
    return nearest;
  }

  /// The blend that x is deepest inside; none if x is on the surface.
  std::optional<std::uint16_t> hidden_by(const glm::dvec3& x) const {
    double deepest = -10.0 * kOnSurface;
    std::optional<std::uint16_t> hider;
    for (const std::uint16_t blend : blends_) {
      const double depth = value(blend, x).value;
      if (depth < deepest) {
        deepest = depth;
        hider = blend;
      }
    }
    return hider;
  }

  /// Moves x along the gradient to where the value of the blend is zero.
  std::optional<Distance> project(std::uint16_t blend, glm::dvec3& x) const {
    for (int step = 0; step < kSteps; ++step) {
      const Distance at = value(blend, x);
      const double square = glm::dot(at.gradient, at.gradient);
      if (square < kFlat) return std::nullopt;
      if (std::abs(at.value) < kOnSurface) return at;
      x -= at.value / square * at.gradient;
    }
    return std::nullopt;
  }

  /// A point that is off the nearest one by a small t along the surface makes the distance d too
  /// large by about t^2 / 2d.
  static bool close_enough(double off, double distance) {
    return off * off <= 2.0 * kGain * std::max(distance, kGain);
  }

  /// A point x of the blend's surface that is nearest to p, at least locally: p - x = lambda *
  /// gradient. This is Newton's method in the tangent plane, (1 + lambda H) step = tangential part
  /// of p - x, where H holds the second derivatives from differences of the gradient. `alone` is
  /// set if p is so near, compared with the radius of curvature, that there is no other such point.
  std::optional<glm::dvec3> nearest_on(std::uint16_t blend, glm::dvec3 x, bool& alone) const {
    alone = false;
    for (int step = 0; step < kSteps; ++step) {
      const auto at = project(blend, x);
      if (!at) return std::nullopt;
      const double slope = length(at->gradient);
      const glm::dvec3 normal = at->gradient / slope;
      const glm::dvec3 way = p_ - x;
      const auto [u, v] = tangents(normal);
      const double du = glm::dot(u, way), dv = glm::dot(v, way);
      const double off = std::sqrt(du * du + dv * dv), distance = length(way);
      const bool done = close_enough(off, distance);
      if (done && step > 0) return x;

      constexpr double kDifference = 1e-6;
      const double lambda = glm::dot(way, normal) / slope / kDifference;
      const glm::dvec3 hu = value(blend, x + kDifference * u).gradient - at->gradient;
      const glm::dvec3 hv = value(blend, x + kDifference * v).gradient - at->gradient;
      const double uu = 1.0 + lambda * glm::dot(u, hu), vv = 1.0 + lambda * glm::dot(v, hv);
      const double uv = 0.5 * lambda * (glm::dot(u, hv) + glm::dot(v, hu));
      const double determinant = uu * vv - uv * uv;
      // True if both eigenvalues are above one half.
      alone = uu > 0.5 && (uu - 0.5) * (vv - 0.5) > uv * uv;
      if (done) return x;
      glm::dvec2 move(du, dv);
      if (uu > 0.0 && determinant > 1e-3 * uu * vv) {
        move = glm::dvec2(vv * du - uv * dv, uu * dv - uv * du) / determinant;
      }
      // Move no further than the surface can be taken to be flat.
      const double moved = std::sqrt(glm::dot(move, move));
      const double limit = std::max(0.5 * distance, 1e-4);
      if (moved > limit) move *= limit / moved;
      x += move.x * u + move.y * v;
    }
    return std::nullopt;
  }

  /// Finds the point nearest to p on the crease of two blends, or at the corner of three.
  void search_crease(std::array<std::uint16_t, 3> blends, int count, glm::dvec3 x) {
    std::array<glm::dvec3, 3> rows;
    std::array<double, 3> right;
    for (int step = 0; step < kSteps; ++step) {
      double off = 0.0;
      for (int i = 0; i < count; ++i) {
        const Distance at = value(blends[static_cast<std::size_t>(i)], x);
        rows[static_cast<std::size_t>(i)] = at.gradient;
        right[static_cast<std::size_t>(i)] = -at.value;
        off = std::max(off, std::abs(at.value));
      }
      double along = 0.0;
      if (count == 2) {  // the third condition: x is the foot of p on the tangent of the crease
        const glm::dvec3 tangent = glm::cross(rows[0], rows[1]);
        const double size = length(tangent);
        if (size < 1e-4) return;
        rows[2] = tangent / size;
        along = right[2] = glm::dot(rows[2], p_ - x);
      }
      const double distance = length(p_ - x);
      if (off < kOnSurface && close_enough(along, distance)) break;
      if (step + 1 == kSteps) return;
      const glm::dvec3 c01 = glm::cross(rows[0], rows[1]), c12 = glm::cross(rows[1], rows[2]),
                       c20 = glm::cross(rows[2], rows[0]);
      const double determinant = glm::dot(rows[0], c12);
      if (std::abs(determinant) < 1e-6) return;
      glm::dvec3 move = (right[0] * c12 + right[1] * c20 + right[2] * c01) / determinant;
      const double moved = length(move), limit = std::max(0.5 * distance, 1e-4);
      if (moved > limit) move *= limit / moved;
      x += move;
    }
    const double distance = length(p_ - x);
    if (distance >= best_) return;
    const auto hider = hidden_by(x);
    if (!hider) {
      best_ = distance;
    } else if (count == 2 && *hider != blends[0] && *hider != blends[1]) {
      blends[2] = *hider;
      search_crease(blends, 3, x);
    }
  }

  const Surface& surface_;
  std::span<const std::uint16_t> blends_;
  glm::dvec3 p_;
  double least_ = 0.0;  ///< a lower bound of the distance
  bool outside_ = true;
  double best_ = kInfinity;
};

/// The distance from a point outside the grid's cells, where no cell tells which blends are near.
double distance_far_away(const Surface& surface, const glm::dvec3& p) {
  std::vector<std::uint16_t> all(surface.blends.size());
  std::iota(all.begin(), all.end(), std::uint16_t{0});
  std::vector<double> values(all.size());
  const double nearest = blend_distances(surface, all, p, values);
  std::vector<std::uint16_t> near;
  for (double reach = 1.5 * std::abs(nearest) + 2.0 * SurfaceGrid::kShell;; reach *= 2.0) {
    near.clear();
    for (const std::uint16_t blend : all) {
      if (values[blend] <= reach) near.push_back(blend);
    }
    // A blend further away than the point that was found is neither nearer, nor does it hide that
    // point.
    const double distance = Search(surface, near, p).run();
    if (distance <= reach || near.size() == all.size()) return distance;
  }
}

}  // namespace

double true_distance(const SurfaceGrid& grid, const glm::dvec3& p) {
  const glm::ivec3 at = grid.cell_at(p);
  if (glm::all(glm::greaterThanEqual(at, glm::ivec3(0))) &&
      glm::all(glm::lessThan(at, grid.size()))) {
    const std::uint32_t number = grid.find(at);
    if (number != SurfaceGrid::kNone) {
      const double distance =
          Search(grid.surface(), grid.blends(grid.cells()[number]), p).run(SurfaceGrid::kShell);
      if (distance <= SurfaceGrid::kShell) return distance;
    }
  }
  return distance_far_away(grid.surface(), p);
}

std::vector<double> true_distances(const SurfaceGrid& grid, const PointCloud& cloud) {
  std::vector<double> distances(cloud.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cloud.size(), 256), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      distances[i] = true_distance(grid, cloud.world(i));
    }
  });
  return distances;
}

}  // namespace pointreel
