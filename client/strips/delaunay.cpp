#include "client/strips/delaunay.h"

#include <algorithm>

namespace pointreel {
namespace {

using Wide = std::int64_t;

/// Above 0 if the three points turn to the left, below if to the right.
Wide turn(const glm::ivec2& a, const glm::ivec2& b, const glm::ivec2& c) {
  return Wide{b.x - a.x} * (c.y - a.y) - Wide{b.y - a.y} * (c.x - a.x);
}

/// Above 0 if d lies inside the circle through a, b and c, which turn to the left.
Wide inside(const glm::ivec2& a, const glm::ivec2& b, const glm::ivec2& c, const glm::ivec2& d) {
  const glm::ivec2 p = a - d, q = b - d, r = c - d;
  const auto square = [](const glm::ivec2& v) { return Wide{v.x} * v.x + Wide{v.y} * v.y; };
  const auto cross = [](const glm::ivec2& v, const glm::ivec2& w) {
    return Wide{v.x} * w.y - Wide{v.y} * w.x;
  };
  return square(p) * cross(q, r) + square(q) * cross(r, p) + square(r) * cross(p, q);
}

std::uint16_t ahead(std::uint16_t edge) {
  return static_cast<std::uint16_t>((edge & 3) == 2 ? edge - 2 : edge + 1);
}

}  // namespace

Delaunay::Edge Delaunay::add(std::uint16_t a, std::uint16_t b, std::uint16_t c) {
  const auto first = static_cast<Edge>(size_);
  corners_[size_] = {a, kNone};
  corners_[size_ + 1] = {b, kNone};
  corners_[size_ + 2] = {c, kNone};
  size_ += 4;
  return first;
}

void Delaunay::join(Edge one, Edge other) {
  corners_[one].twin = other;
  corners_[other].twin = one;
}

/// Connects a point to the points before it, which lie on a line.
void Delaunay::start(std::size_t chain, std::uint16_t point) {
  const bool left = turn(points_[sorted_[0]], points_[sorted_[chain - 1]], points_[point]) > 0;
  if (!left) std::reverse(sorted_.begin(), sorted_.begin() + static_cast<std::ptrdiff_t>(chain));
  Edge before = kNone;  // the edge from the new point to the last one
  for (std::size_t i = 0; i + 1 < chain; ++i) {
    const std::uint16_t a = sorted_[i], b = sorted_[i + 1];
    const Edge edge = add(a, b, point);
    rim_[a] = edge;
    next_[a] = b;
    last_[b] = a;
    const auto to_a = static_cast<Edge>(edge + 2);
    if (before == kNone) {
      rim_[point] = to_a;
      next_[point] = a;
      last_[a] = point;
    } else {
      join(to_a, before);
    }
    before = static_cast<Edge>(edge + 1);
  }
  const std::uint16_t end = sorted_[chain - 1];
  rim_[end] = before;
  next_[end] = point;
  last_[point] = end;
  if (!left) std::reverse(sorted_.begin(), sorted_.begin() + static_cast<std::ptrdiff_t>(chain));
  for (std::size_t i = 0; i < size_; i += 4) open_.push_back(static_cast<Edge>(i));
}

/// Connects a point, which lies to the right of all before it, to the edges of the rim that it
/// sees. `before`: the last one, where the rim is nearest.
void Delaunay::insert(std::uint16_t point, std::uint16_t before) {
  const glm::ivec2 p = points_[point];
  std::uint16_t upper = before, lower = before;
  Edge above = kNone, below = kNone;  // the outermost edges at the new point
  Edge first_from = kNone;            // from `before` to it, in the first triangle upwards
  while (turn(points_[upper], points_[next_[upper]], p) < 0) {
    const std::uint16_t beyond = next_[upper];
    const Edge edge = add(beyond, upper, point);
    join(edge, rim_[upper]);
    open_.push_back(edge);
    const auto from_upper = static_cast<Edge>(edge + 1);
    if (above == kNone)
      first_from = from_upper;
    else
      join(from_upper, above);
    above = static_cast<Edge>(edge + 2);
    upper = beyond;
  }
  while (turn(points_[last_[lower]], points_[lower], p) < 0) {
    const std::uint16_t beyond = last_[lower];
    const Edge edge = add(lower, beyond, point);
    join(edge, rim_[beyond]);
    open_.push_back(edge);
    const auto to_lower = static_cast<Edge>(edge + 2);
    if (below == kNone) {
      if (first_from != kNone)
        join(to_lower, first_from);
      else
        above = to_lower;
    } else {
      join(to_lower, below);
    }
    below = static_cast<Edge>(edge + 1);
    lower = beyond;
  }
  if (below == kNone) below = first_from;
  next_[lower] = point;
  last_[point] = lower;
  rim_[lower] = below;
  next_[point] = upper;
  last_[upper] = point;
  rim_[point] = above;
}

/// Flips edges opposite to the new point until the triangulation is Delaunay again.
void Delaunay::legalize() {
  Corner* const corners = corners_.data();
  while (!open_.empty()) {
    const Edge edge = open_.back();
    open_.pop_back();
    const Edge twin = corners[edge].twin;
    if (twin == kNone) continue;
    // The edge runs from a to b; c, to its left, is the new point, d is to its right.
    const Edge b_c = ahead(edge), c_a = ahead(b_c), a_d = ahead(twin), d_b = ahead(a_d);
    const std::uint16_t a = corners[edge].point, b = corners[twin].point, c = corners[c_a].point,
                        d = corners[d_b].point;
    const Wide in = inside(points_[a], points_[b], points_[c], points_[d]);
    if (in < 0 || (in == 0 && std::min(a, b) < std::min(c, d))) continue;
    // The two triangles become (c, a, d) and (d, b, c), in this order in memory.
    const Edge beyond_b_c = corners[b_c].twin, beyond_c_a = corners[c_a].twin,
               beyond_a_d = corners[a_d].twin, beyond_d_b = corners[d_b].twin;
    const auto one = static_cast<Edge>(edge & ~3), other = static_cast<Edge>(twin & ~3);
    const auto set = [&](int to, Edge beyond, std::uint16_t from) {
      corners[to] = {from, beyond};
      if (beyond != kNone)
        corners[beyond].twin = static_cast<Edge>(to);
      else
        rim_[from] = static_cast<Edge>(to);
    };
    set(one, beyond_c_a, c);
    set(one + 1, beyond_a_d, a);
    corners[one + 2] = {d, static_cast<Edge>(other + 2)};
    set(other, beyond_d_b, d);
    set(other + 1, beyond_b_c, b);
    corners[other + 2] = {c, static_cast<Edge>(one + 2)};
    open_.push_back(static_cast<Edge>(one + 1));
    open_.push_back(other);
  }
}

std::span<const Delaunay::Triangle> Delaunay::run(std::span<const glm::ivec2> points) {
  points_ = points;
  size_ = 0;
  triangles_.clear();
  order_.clear();
  sorted_.clear();
  const std::size_t count = std::min(points.size(), kMostPoints);
  for (std::size_t i = 0; i < count; ++i) {
    const auto biased = [](int v) { return static_cast<std::uint64_t>(v + kReach); };
    order_.push_back(biased(points[i].x) << 32 | biased(points[i].y) << 16 | i);
  }
  std::sort(order_.begin(), order_.end());
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0 && order_[i] >> 16 == order_[i - 1] >> 16) continue;
    sorted_.push_back(static_cast<std::uint16_t>(order_[i] & 0xffff));
  }
  next_.resize(std::max(next_.size(), count));
  last_.resize(next_.size());
  rim_.resize(next_.size());
  corners_.resize(std::max(corners_.size(), 8 * count));
  std::size_t chain = 2;
  while (chain < sorted_.size() &&
         turn(points[sorted_[0]], points[sorted_[1]], points[sorted_[chain]]) == 0)
    ++chain;
  if (chain >= sorted_.size()) return {};
  start(chain, sorted_[chain]);
  legalize();
  for (std::size_t i = chain + 1; i < sorted_.size(); ++i) {
    insert(sorted_[i], sorted_[i - 1]);
    legalize();
  }
  for (std::size_t i = 0; i < size_; i += 4)
    triangles_.push_back({corners_[i].point, corners_[i + 1].point, corners_[i + 2].point});
  return triangles_;
}

}  // namespace pointreel
