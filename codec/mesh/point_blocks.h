#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include <glm/glm.hpp>

#include "codec/core/radix_sort.h"
#include "pointreel/cloud.h"
#include "pointreel/executor.h"

namespace pointreel {

/// A regular grid around a cloud, whose cells have the edge `cell`. Coordinates within it count
/// cells, and those of points and samples are at least 0.
struct MeshGrid {
  glm::dvec3 corner{0.0};  ///< in the local coordinates of the cloud
  double cell = 1.0;       ///< in the units of the cloud

  glm::dvec3 inside(const glm::vec3& local) const { return (glm::dvec3(local) - corner) / cell; }
  glm::dvec3 outside(const glm::dvec3& place) const { return place * cell + corner; }
};

/// The grid in blocks of 4 x 4 x 4 cells. A block has the samples at the minimum corners of its
/// cells, and knows the points that may lie within reach of them. Only blocks with such points
/// exist.
class PointBlocks {
 public:
  static constexpr int kBits = 2, kEdge = 1 << kBits;
  static constexpr std::size_t kCells = kEdge * kEdge * kEdge;
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  /// Coordinates of blocks are below 2^kMostBits, so that their Morton codes have 63 bits.
  static constexpr int kMostBits = 21;

  /// `reaches`: for each point of the cloud, how far it is seen, in cells.
  PointBlocks(const PointCloud& cloud, const MeshGrid& grid, std::span<const float> reaches,
              const Executor& executor);

  /// About how much memory it takes to make them, in bytes.
  static std::uint64_t memory(std::span<const float> reaches);

  std::size_t size() const { return starts_.size(); }
  /// The coordinates of the block's first cell.
  glm::ivec3 corner(std::uint32_t block) const;
  /// The block with that first cell, or kNone.
  std::uint32_t find(const glm::ivec3& corner) const;
  /// The points, in the order of the cloud.
  std::span<const KeyIndex> points(std::uint32_t block) const;

 private:
  std::vector<KeyIndex> seen_;  ///< a block's key and a point that it sees
  std::vector<std::size_t> starts_;
  std::unordered_map<std::uint64_t, std::uint32_t> by_key_;
};

}  // namespace pointreel
