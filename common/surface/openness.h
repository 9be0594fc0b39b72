#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "pointreel/octree.h"

namespace pointreel {

/// How freely each cell of a coarse grid is seen from outside: of the 26 directions to a cell's
/// neighbours, how many leave the grid without meeting an occupied cell. 0 inside a closed surface,
/// few inside one with holes, many outside, also in folds that no ray along the normal leaves.
///
/// All rows of the grid are words of bits, so that one direction is one sweep of shifts and masks
/// over the grid: 26 sweeps of 128^3 cells take about two milliseconds.
class Openness {
 public:
  static constexpr int kMaxLevel = 7;

  /// Of the occupied cells of `svo` at `level`, which is at most kMaxLevel and svo.depth.
  Openness(const Svo& svo, int level);

  /// Edge of a cell, in the units of the cube.
  double cell_size() const { return cell_size_; }

  /// 0 to 26 at a position relative to the cube's minimum corner; 0 in occupied cells, 26 outside
  /// the grid.
  int at(const glm::vec3& p) const;

 private:
  void sweep(const glm::ivec3& direction, std::vector<std::uint64_t>& open) const;
  void count(const std::vector<std::uint64_t>& open);

  int side_;           ///< cells an axis, a power of two
  std::size_t words_;  ///< 64-bit words a row
  double cell_size_;
  double cells_per_unit_;
  std::vector<std::uint64_t> empty_;  ///< a bit a cell, x fastest, rows by y, then z
  /// The counts of 64 cells, a word for each binary digit.
  std::vector<std::array<std::uint64_t, 5>> counts_;
};

}  // namespace pointreel
