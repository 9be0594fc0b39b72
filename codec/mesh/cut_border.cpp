#include "codec/mesh/cut_border.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace pointreel {
namespace {

constexpr int kSmoothings = 2;
/// Vertices that are nearer to the line than this share of an edge move onto it.
constexpr float kSnap = 0.3f;

/// Calls edge(a, b) for each side of each triangle.
template <class Edge>
void for_edges(const TriangleMesh& mesh, const Edge& edge) {
  for (const glm::uvec3& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) edge(t[i], t[(i + 1) % 3]);
  }
}

std::vector<float> smoothed(const TriangleMesh& mesh, std::span<const float> values) {
  std::vector<float> now(values.begin(), values.end());
  for (int round = 0; round < kSmoothings; ++round) {
    std::vector<float> sums = now;
    std::vector<float> counts(now.size(), 1.0f);
    for_edges(mesh, [&](std::uint32_t a, std::uint32_t b) {
      sums[a] += now[b];
      sums[b] += now[a];
      counts[a] += 1.0f;
      counts[b] += 1.0f;
    });
    for (std::size_t i = 0; i < now.size(); ++i) now[i] = sums[i] / counts[i];
  }
  return now;
}

class Cut {
 public:
  Cut(TriangleMesh& mesh, std::vector<float> above)
      : mesh_(mesh), above_(std::move(above)), positions_(mesh.vertices.positions) {}

  void run() {
    snap();
    std::vector<glm::uvec3> kept;
    kept.reserve(mesh_.triangles.size());
    for (const glm::uvec3& t : mesh_.triangles) add_below(t, kept);
    mesh_.triangles = std::move(kept);
  }

 private:
  void snap() {
    std::vector<float> nearest(above_.size(), kSnap);
    std::vector<std::uint32_t> towards(above_.size(), 0);
    for_edges(mesh_, [&](std::uint32_t a, std::uint32_t b) {
      if (!(above_[a] < 0.0f) == !(above_[b] < 0.0f)) return;
      const float t = above_[a] / (above_[a] - above_[b]);
      if (t < nearest[a]) {
        nearest[a] = t;
        towards[a] = b;
      }
      if (1.0f - t < nearest[b]) {
        nearest[b] = 1.0f - t;
        towards[b] = a;
      }
    });
    for (std::uint32_t i = 0; i < above_.size(); ++i) {
      if (!(nearest[i] < kSnap)) continue;
      mesh_.vertices.positions[i] = glm::mix(positions_[i], positions_[towards[i]], nearest[i]);
      above_[i] = 0.0f;
    }
  }

  /// The vertex where the line crosses an edge.
  std::uint32_t crossing(std::uint32_t a, std::uint32_t b) {
    const std::uint64_t key = std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
    PointCloud& vertices = mesh_.vertices;
    const auto [at, is_new] =
        crossings_.emplace(key, static_cast<std::uint32_t>(vertices.positions.size()));
    if (!is_new) return at->second;
    const float t = above_[a] / (above_[a] - above_[b]);
    vertices.positions.push_back(glm::mix(vertices.positions[a], vertices.positions[b], t));
    const glm::vec3 normal = glm::mix(vertices.normals[a], vertices.normals[b], t);
    const float length = glm::length(normal);
    vertices.normals.push_back(length > 0.0f ? normal / length : vertices.normals[a]);
    if (vertices.has_colors()) {
      const glm::vec3 color =
          glm::mix(glm::vec3(vertices.colors[a]), glm::vec3(vertices.colors[b]), t);
      vertices.colors.emplace_back(color + 0.5f);
    }
    return at->second;
  }

  /// Adds the part of a triangle that is below the line.
  void add_below(const glm::uvec3& t, std::vector<glm::uvec3>& kept) {
    std::array<std::uint32_t, 4> corners{};
    std::size_t count = 0;
    bool below = false;
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i], b = t[(i + 1) % 3];
      below |= above_[a] < 0.0f;
      if (above_[a] <= 0.0f) corners[count++] = a;
      if (above_[a] * above_[b] < 0.0f) corners[count++] = crossing(a, b);
    }
    if (!below || count < 3) return;
    kept.emplace_back(corners[0], corners[1], corners[2]);
    if (count == 4) kept.emplace_back(corners[0], corners[2], corners[3]);
  }

  TriangleMesh& mesh_;
  std::vector<float> above_;  ///< the line is where it is 0
  std::vector<glm::vec3> positions_;
  std::unordered_map<std::uint64_t, std::uint32_t> crossings_;
};

}  // namespace

void cut_border(TriangleMesh& mesh, std::span<const float> beside) {
  std::vector<float> above = smoothed(mesh, beside);
  for (float& value : above) value -= 1.0f;
  Cut(mesh, std::move(above)).run();
}

}  // namespace pointreel
