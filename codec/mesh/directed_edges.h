#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace pointreel {

/// The sides of triangles, each from one vertex to the next.
class DirectedEdges {
 public:
  explicit DirectedEdges(std::span<const glm::uvec3> triangles) {
    edges_.reserve(3 * triangles.size());
    for (const glm::uvec3& t : triangles) {
      for (int i = 0; i < 3; ++i) edges_.push_back(key(t[i], t[(i + 1) % 3]));
    }
    std::sort(edges_.begin(), edges_.end());
  }

  bool contains(std::uint32_t from, std::uint32_t to) const {
    return std::binary_search(edges_.begin(), edges_.end(), key(from, to));
  }

  template <class Edge>
  void for_each(const Edge& edge) const {
    for (const std::uint64_t e : edges_)
      edge(static_cast<std::uint32_t>(e >> 32), static_cast<std::uint32_t>(e));
  }

  static std::uint64_t key(std::uint32_t from, std::uint32_t to) {
    return std::uint64_t{from} << 32 | to;
  }

 private:
  std::vector<std::uint64_t> edges_;
};

}  // namespace pointreel
