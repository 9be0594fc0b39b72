#include "codec/mesh/tidy.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "codec/mesh/directed_edges.h"

namespace pointreel {
namespace {

/// Which vertices hang together.
class Parts {
 public:
  explicit Parts(std::size_t vertices) : parent_(vertices) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }

  std::uint32_t of(std::uint32_t vertex) {
    while (parent_[vertex] != vertex) vertex = parent_[vertex] = parent_[parent_[vertex]];
    return vertex;
  }
  void join(std::uint32_t a, std::uint32_t b) { parent_[of(a)] = of(b); }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace

void remove_specks(TriangleMesh& mesh, std::size_t least) {
  Parts parts(mesh.vertices.size());
  for (const glm::uvec3& t : mesh.triangles) {
    parts.join(t.x, t.y);
    parts.join(t.y, t.z);
  }
  std::vector<std::size_t> sizes(mesh.vertices.size(), 0);
  std::size_t largest = 0;
  for (const glm::uvec3& t : mesh.triangles) largest = std::max(largest, ++sizes[parts.of(t.x)]);
  least = std::min(least, largest);
  std::erase_if(mesh.triangles, [&](const glm::uvec3& t) { return sizes[parts.of(t.x)] < least; });
}

void remove_unused_vertices(TriangleMesh& mesh) {
  constexpr std::uint32_t kUnused = ~std::uint32_t{0};
  PointCloud& from = mesh.vertices;
  PointCloud used;
  used.origin = from.origin;
  std::vector<std::uint32_t> place(from.size(), kUnused);
  for (glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t vertex = triangle[i];
      if (place[vertex] == kUnused) {
        place[vertex] = static_cast<std::uint32_t>(used.size());
        used.positions.push_back(from.positions[vertex]);
        used.normals.push_back(from.normals[vertex]);
        if (from.has_colors()) used.colors.push_back(from.colors[vertex]);
      }
      triangle[i] = place[vertex];
    }
  }
  from = std::move(used);
}

void remove_folds(TriangleMesh& mesh) {
  const std::vector<glm::vec3>&p = mesh.vertices.positions, &n = mesh.vertices.normals;
  std::erase_if(mesh.triangles, [&](const glm::uvec3& t) {
    const glm::dvec3 a(p[t.x]), b(p[t.y]), c(p[t.z]);
    const glm::dvec3 normal(n[t.x] + n[t.y] + n[t.z]);
    return !(glm::dot(glm::cross(b - a, c - a), normal) > 0.0);
  });
}

void keep_manifold(TriangleMesh& mesh) {
  // An edge that several triangles have in the same direction loses all of these: none of them is
  // better than the others.
  std::vector<std::uint64_t> edges, repeated;
  edges.reserve(3 * mesh.triangles.size());
  for (const glm::uvec3& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) edges.push_back(DirectedEdges::key(t[i], t[(i + 1) % 3]));
  }
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 1; i < edges.size(); ++i) {
    if (edges[i] == edges[i - 1]) repeated.push_back(edges[i]);
  }
  if (repeated.empty()) return;
  std::erase_if(mesh.triangles, [&](const glm::uvec3& t) {
    for (int i = 0; i < 3; ++i) {
      if (std::binary_search(repeated.begin(), repeated.end(),
                             DirectedEdges::key(t[i], t[(i + 1) % 3])))
        return true;
    }
    return false;
  });
}

}  // namespace pointreel
