#include "client/strips/decimation.h"

#include <algorithm>
#include <span>
#include <utility>

namespace pointreel {
namespace {

using Corners = std::array<std::uint32_t, 3>;

/// Whether triangles, which are sorted by their corners, contain one with these corners, however it
/// is turned.
bool contains(std::span<const PatchTriangle> triangles, Corners corners) {
  std::sort(corners.begin(), corners.end());
  auto at = std::lower_bound(triangles.begin(), triangles.end(), corners[0],
                             [](const PatchTriangle& triangle, std::uint32_t first) {
                               return triangle.corners[0] < first;
                             });
  for (; at != triangles.end() && at->corners[0] == corners[0]; ++at) {
    const auto [low, high] = std::minmax(at->corners[1], at->corners[2]);
    if (low == corners[1] && high == corners[2]) return true;
  }
  return false;
}

/// Places in a triangle at which it is looked whether others cover it: shares of its corners.
constexpr std::array<glm::vec3, 7> kPlaces = {
    glm::vec3(0.96f, 0.02f, 0.02f), glm::vec3(0.02f, 0.96f, 0.02f), glm::vec3(0.02f, 0.02f, 0.96f),
    glm::vec3(0.02f, 0.49f, 0.49f), glm::vec3(0.49f, 0.02f, 0.49f), glm::vec3(0.49f, 0.49f, 0.02f),
    glm::vec3(0.34f, 0.33f, 0.33f)};
constexpr unsigned kAllPlaces = (1u << kPlaces.size()) - 1;

/// Triangles that are turned farther from each other do not cover one another.
constexpr float kLeastCosine = 0.4f;

}  // namespace

void Decimation::find_rivals(std::uint32_t patch, const PatchTriangle& triangle) {
  rivals_.clear();
  for (const std::uint32_t corner : triangle.corners) {
    const std::uint32_t owner = tree_.patch_of[corner];
    if (owner < patch && std::find(rivals_.begin(), rivals_.end(), owner) == rivals_.end())
      rivals_.push_back(owner);
  }
}

bool Decimation::redundant(const PatchTriangle& triangle) const {
  return std::any_of(rivals_.begin(), rivals_.end(), [&](std::uint32_t rival) {
    return contains(patches_.triangles(rival), triangle.corners);
  });
}

bool Decimation::covered(const PatchTriangle& triangle) const {
  const auto [a, b, c] = triangle.corners;
  const glm::vec3 origin = surfels_.positions[a];
  const auto edge_to = [&](std::uint32_t i) { return surfels_.positions[i] - origin; };
  const glm::vec3 ab = edge_to(b), ac = edge_to(c), normal = glm::cross(ab, ac);
  std::array<glm::vec3, kPlaces.size()> places;
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = kPlaces[i].y * ab + kPlaces[i].z * ac;
  unsigned found = 0;
  for (const std::uint32_t rival : rivals_) {
    for (const PatchTriangle& other : patches_.triangles(rival)) {
      const auto shares = [&](std::uint32_t i) { return i == a || i == b || i == c; };
      if (!shares(other.corners[0]) && !shares(other.corners[1]) && !shares(other.corners[2]))
        continue;
      const glm::vec3 p = edge_to(other.corners[0]), q = edge_to(other.corners[1]),
                      r = edge_to(other.corners[2]);
      const glm::vec3 other_normal = glm::cross(q - p, r - p);
      float cosine = glm::dot(normal, other_normal);
      const float side = surfels_.lines && cosine < 0.0f ? -1.0f : 1.0f;
      cosine *= side;
      if (!(cosine > 0.0f && cosine * cosine > kLeastCosine * kLeastCosine *
                                                   glm::dot(normal, normal) *
                                                   glm::dot(other_normal, other_normal)))
        continue;
      // As seen along the normal of the triangle itself.
      const glm::vec3 along = side * normal;
      const float slack = 1e-4f * cosine;
      for (std::size_t i = 0; i < places.size(); ++i) {
        const glm::vec3 x = p - places[i], y = q - places[i], z = r - places[i];
        if (glm::dot(along, glm::cross(x, y)) >= -slack &&
            glm::dot(along, glm::cross(y, z)) >= -slack &&
            glm::dot(along, glm::cross(z, x)) >= -slack)
          found |= 1u << i;
      }
      if (found == kAllPlaces) return true;
    }
  }
  return false;
}

void Decimation::run(std::uint32_t patch, std::vector<Corners>& out) {
  for (const PatchTriangle& triangle : patches_.triangles(patch)) {
    if (!triangle.inner) {
      find_rivals(patch, triangle);
      if (!rivals_.empty() && (redundant(triangle) || covered(triangle))) continue;
    }
    out.push_back(triangle.corners);
  }
}

}  // namespace pointreel
