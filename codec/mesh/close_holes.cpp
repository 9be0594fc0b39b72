#include "codec/mesh/close_holes.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "codec/mesh/directed_edges.h"

namespace pointreel {
namespace {

/// Adds a vertex in the middle of a ring. Returns its number.
std::uint32_t add_middle(PointCloud& vertices, std::span<const std::uint32_t> ring) {
  const float share = 1.0f / static_cast<float>(ring.size());
  glm::vec3 position(0.0f), normal(0.0f), color(0.0f);
  for (const std::uint32_t i : ring) {
    position += share * vertices.positions[i];
    normal += vertices.normals[i];
    if (vertices.has_colors()) color += share * glm::vec3(vertices.colors[i]);
  }
  const float length = glm::length(normal);
  if (vertices.has_colors()) vertices.colors.emplace_back(color + 0.5f);
  vertices.normals.push_back(length > 0.0f ? normal / length : vertices.normals[ring[0]]);
  vertices.positions.push_back(position);
  return static_cast<std::uint32_t>(vertices.size() - 1);
}

/// Whether a fan over the ring around its middle faces the way of the normals there.
bool faces_outward(const PointCloud& vertices, std::span<const std::uint32_t> ring) {
  glm::dvec3 middle(0.0), normal(0.0), area(0.0);
  for (const std::uint32_t i : ring) {
    middle += glm::dvec3(vertices.positions[i]) / static_cast<double>(ring.size());
    normal += glm::dvec3(vertices.normals[i]);
  }
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const glm::dvec3 a(vertices.positions[ring[i]]);
    const glm::dvec3 b(vertices.positions[ring[(i + 1) % ring.size()]]);
    const glm::dvec3 side = glm::cross(a - middle, b - middle);
    if (!(glm::dot(side, normal) > 0.0)) return false;
    area += side;
  }
  return glm::dot(area, normal) > 0.0;
}

void close(TriangleMesh& mesh, std::span<const std::uint32_t> ring) {
  if (ring.size() < 3 || !faces_outward(mesh.vertices, ring)) return;
  if (ring.size() == 3) {
    mesh.triangles.emplace_back(ring[0], ring[1], ring[2]);
    return;
  }
  const std::uint32_t middle = add_middle(mesh.vertices, ring);
  for (std::size_t i = 0; i < ring.size(); ++i)
    mesh.triangles.emplace_back(ring[i], ring[(i + 1) % ring.size()], middle);
}

}  // namespace

void close_holes(TriangleMesh& mesh, std::size_t edges) {
  const DirectedEdges all(mesh.triangles);
  // Around a hole, the edges lead from one vertex to the next against the triangles beside them.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> open;
  all.for_each([&](std::uint32_t a, std::uint32_t b) {
    if (!all.contains(b, a)) open.emplace_back(b, a);
  });
  std::sort(open.begin(), open.end());
  std::vector<bool> used(open.size(), false);
  const auto next_from = [&](std::uint32_t vertex) {
    auto at = std::lower_bound(open.begin(), open.end(), std::pair(vertex, std::uint32_t{0}));
    for (; at != open.end() && at->first == vertex; ++at) {
      const auto index = static_cast<std::size_t>(at - open.begin());
      if (!used[index]) return index;
    }
    return open.size();
  };
  for (std::size_t first = 0; first < open.size(); ++first) {
    if (used[first]) continue;
    std::vector<std::uint32_t> path = {open[first].first};
    // A path that meets itself has gone around a hole, and goes on where it met itself.
    for (std::size_t edge = first; edge < open.size(); edge = next_from(path.back())) {
      used[edge] = true;
      const std::uint32_t vertex = open[edge].second;
      const std::size_t reach = std::min(path.size(), edges);
      const auto begin = path.end() - static_cast<std::ptrdiff_t>(reach);
      if (const auto met = std::find(begin, path.end(), vertex); met != path.end()) {
        close(mesh, std::span(met, path.end()));
        path.erase(met + 1, path.end());
        if (path.size() == 1) break;
      } else {
        path.push_back(vertex);
      }
    }
  }
}

}  // namespace pointreel
