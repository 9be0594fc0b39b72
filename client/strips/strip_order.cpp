#include "client/strips/strip_order.h"

#include <algorithm>
#include <cstddef>

namespace pointreel {
namespace {

using Corners = std::array<std::uint32_t, 3>;

std::uint16_t next_edge(std::uint16_t edge) {
  return static_cast<std::uint16_t>(edge % 3 == 2 ? edge - 2 : edge + 1);
}

}  // namespace

void StripOrder::find_neighbors(std::span<const Corners> triangles) {
  edges_.clear();
  twins_.assign(3 * triangles.size(), kNone);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangles[i][k], b = triangles[i][(k + 1) % 3];
      const std::uint64_t ends = std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
      edges_.push_back({ends, static_cast<std::uint16_t>(3 * i + k)});
    }
  }
  std::sort(edges_.begin(), edges_.end(), [](const Edge& a, const Edge& b) {
    return a.ends != b.ends ? a.ends < b.ends : a.edge < b.edge;
  });
  for (std::size_t i = 0; i + 1 < edges_.size(); ++i) {
    const std::uint16_t one = edges_[i].edge, other = edges_[i + 1].edge;
    if (edges_[i].ends != edges_[i + 1].ends) continue;
    // Only triangles that are turned the same way follow each other in a strip.
    if (triangles[one / 3u][one % 3u] == triangles[other / 3u][other % 3u]) continue;
    twins_[one] = other;
    twins_[other] = one;
    ++i;
  }
}

std::uint16_t StripOrder::across(std::uint16_t edge) const {
  const std::uint16_t twin = twins_[edge];
  return twin == kNone || done_[twin / 3u] != 0 ? kNone : twin;
}

void StripOrder::run(std::span<const Corners> triangles, std::vector<std::uint32_t>& indices) {
  find_neighbors(triangles);
  done_.assign(triangles.size(), 0);
  const auto neighbors_left = [this](std::size_t triangle) {
    int left = 0;
    for (std::size_t k = 0; k < 3; ++k)
      if (across(static_cast<std::uint16_t>(3 * triangle + k)) != kNone) ++left;
    return left;
  };
  const auto corner = [&](std::uint16_t edge) { return triangles[edge / 3u][edge % 3u]; };
  std::size_t waiting = 0;  // all triangles before it are done
  std::size_t near = 0;     // where to look for the next one
  for (;;) {
    while (waiting < triangles.size() && done_[waiting] != 0) ++waiting;
    if (waiting == triangles.size()) return;
    // The triangle with the fewest neighbours left of some that are near the last strip.
    constexpr std::size_t kLook = 8;
    std::size_t start = waiting;
    int fewest = 4;
    const std::size_t from = std::max(waiting, near);
    for (std::size_t i = from, seen = 0; i < triangles.size() && seen < kLook; ++i) {
      if (done_[i] != 0) continue;
      ++seen;
      if (const int left = neighbors_left(i); left < fewest) {
        fewest = left;
        start = i;
      }
    }
    // Turned so that there is a neighbour to go to, and after it one on the other side.
    auto out = static_cast<std::uint16_t>(3 * start);
    int best = -1;
    done_[start] = 1;
    for (std::uint16_t k = 0; k < 3; ++k) {
      const auto edge = static_cast<std::uint16_t>(3 * start + k);
      const std::uint16_t next = across(edge);
      const int score = next == kNone ? 0 : across(next_edge(next_edge(next))) == kNone ? 1 : 2;
      if (score > best) {
        best = score;
        out = edge;
      }
    }
    // The strip leaves the triangle (a, b, c) through the edge from b to c.
    const std::uint16_t a = next_edge(next_edge(out));
    indices.insert(indices.end(), {corner(a), corner(out), corner(next_edge(out))});
    bool turned = true;  // whether the next triangle is turned around
    for (std::uint16_t edge = across(out); edge != kNone;) {
      // The new triangle's edge runs from c to b; its far corner is the next index.
      const std::uint16_t to_far = next_edge(edge), from_far = next_edge(to_far);
      done_[edge / 3u] = 1;
      indices.push_back(corner(from_far));
      near = edge / 3u;
      // From here through the edge between the last two indices: c and the far corner.
      edge = across(turned ? from_far : to_far);
      turned = !turned;
    }
    indices.push_back(kEndOfStrip);
  }
}

}  // namespace pointreel
