#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "pointreel/octree.h"

namespace pointreel {

/// How visible each cell of a coarse grid is from outside: the number of the 26 directions to its
/// neighbours in which a ray leaves the grid without meeting an occupied cell. It is 0 inside a
/// closed surface, small inside a surface with holes, and large outside, even in folds that no ray
/// along the normal leaves.
///
/// The rows of the grid are words of bits, so that a direction takes one sweep of shifts and masks
/// over the grid. All 26 sweeps of 128^3 cells take about two milliseconds.
class Openness {
 public:
  static constexpr int kMaxLevel = 7;

  /// The occupied cells are those of `svo` at `level`, which is at most kMaxLevel and svo.depth.
  Openness(const Svo& svo, int level);

  /// The edge of a cell, in the units of the cube.
  double cell_size() const { return cell_size_; }

  /// The number of open directions, 0 to 26, at a position relative to the cube's minimum corner.
  /// It is 0 in occupied cells and 26 outside the grid.
  int at(const glm::vec3& p) const;

 private:
  void sweep(const glm::ivec3& direction, std::vector<std::uint64_t>& open) const;
  void count(const std::vector<std::uint64_t>& open);

  int side_;           ///< number of cells along an axis, a power of two
  std::size_t words_;  ///< number of 64-bit words in a row
  double cell_size_;
  double cells_per_unit_;
  std::vector<std::uint64_t> empty_;  ///< one bit for each cell, x fastest, rows by y, then z
  /// The counts of 64 cells at a time, with one word for each binary digit.
  std::vector<std::array<std::uint64_t, 5>> counts_;
};

}  // namespace pointreel
