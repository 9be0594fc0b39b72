#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "datasets_synthetic/ray_primitive.h"
#include "datasets_synthetic/sdf.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"

namespace pointreel {

/// The space around a surface in cells of 11 mm: which of them the surface may pass through, and
/// the few of its blends that matter there. What samples a surface or casts rays at it evaluates
/// only those. Cells lie in blocks of 8^3, of which most are empty and skipped whole.
class SurfaceGrid {
 public:
  static constexpr double kCell =
      0.011;  ///< metres; about the fastest for 90,000 points on a person
  /// Every point at most this far from the surface (metres) lies in a cell that is listed.
  static constexpr double kShell = 0.0025;
  /// A cell lists all blends that are at most this far from its centre: half its diagonal, kShell.
  static constexpr double kListed = 0.5 * 1.7320508075688772 * kCell + kShell;
  static constexpr int kBlock = 8;               ///< cells along the edge of a block
  static constexpr std::size_t kMaxBlends = 32;  ///< that matter in one cell
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  struct Cell {
    glm::dvec3 min;
    double distance;  ///< of the centre, signed: no point of the surface is nearer to it
    std::uint32_t first_blend, blend_count;
  };

  /// Refuses a surface without parts, one that is not finite, one larger than 11 m, and one with
  /// more than kMaxBlends blends in one place.
  static Result<SurfaceGrid> build(Surface surface);

  const Surface& surface() const { return surface_; }

  /// The surface's primitives, for rays.
  std::span<const RayPrimitive> ray_primitives() const { return ray_primitives_; }

  /// The cells that are listed, those of a block together. None if the surface has no area.
  std::span<const Cell> cells() const { return cells_; }

  /// The blends that decide the distance in the cell and up to kShell around it, by their distance
  /// at the cell's centre.
  std::span<const std::uint16_t> blends(const Cell& cell) const {
    return {blends_.data() + cell.first_blend, cell.blend_count};
  }

  /// The distance of each of them at the cell's centre.
  std::span<const float> blend_values(const Cell& cell) const {
    return {blend_values_.data() + cell.first_blend, cell.blend_count};
  }

  /// distance_to the surface at a point of the cell or up to kShell around it, to within rounding
  /// (see RayPrimitive); faster.
  SurfaceDistance distance(const Cell& cell, const glm::dvec3& p) const;

  /// Minimum corner and number of cells along each axis; whole blocks.
  const glm::dvec3& origin() const { return origin_; }
  const glm::ivec3& size() const { return size_; }

  /// Coordinates of the cell that holds p; beyond 0 and `size` outside the grid.
  glm::ivec3 cell_at(const glm::dvec3& p) const;

  /// Whether any cell of the block of this cell is listed. The coordinates are within `size`.
  bool block_occupied(const glm::ivec3& cell) const { return block(cell) != kNone; }

  /// Number of the cell of these coordinates (within `size`) in `cells`, or kNone.
  std::uint32_t find(const glm::ivec3& cell) const {
    const std::uint32_t number = block(cell);
    if (number == kNone) return kNone;
    const glm::uvec3 at = glm::uvec3(cell) % unsigned{kBlock};
    const std::size_t local = at.x + kBlock * (at.y + kBlock * at.z);
    return lookup_[std::size_t{number} * kBlock * kBlock * kBlock + local];
  }

 private:
  explicit SurfaceGrid(Surface surface)
      : surface_(std::move(surface)),
        ray_primitives_(surface_.primitives.begin(), surface_.primitives.end()) {}

  void divide(const glm::dvec3& min, const glm::ivec3& first, int level,
              std::span<const std::uint16_t> candidates);
  void make_lookup();

  /// The distances of blends at p, into values_; returns the smallest.
  double blend_values_at(std::span<const std::uint16_t> blends, const glm::dvec3& p);

  std::uint32_t block(const glm::ivec3& cell) const {
    const glm::uvec3 at = glm::uvec3(cell) / unsigned{kBlock};
    const glm::uvec3 count = glm::uvec3(size_) / unsigned{kBlock};
    return blocks_[at.x + std::size_t{count.x} * (at.y + std::size_t{count.y} * at.z)];
  }

  Surface surface_;
  std::vector<RayPrimitive> ray_primitives_;
  glm::dvec3 origin_{0.0};
  glm::ivec3 size_{0};
  std::vector<Cell> cells_;
  std::vector<glm::ivec3> coordinates_;  ///< of each cell
  std::vector<std::uint16_t> blends_;
  std::vector<float> blend_values_;
  /// While it is built: what is known of each primitive, and since which evaluation.
  struct Known {
    std::uint64_t evaluation = 0;
    double value = 0.0;
  };
  std::vector<Known> known_;
  std::vector<double> values_;
  std::uint64_t evaluation_ = 0;
  std::vector<std::uint32_t> blocks_;  ///< number of each block that is not empty
  std::vector<std::uint32_t> lookup_;  ///< number of each cell of those blocks, x fastest
};

}  // namespace pointreel
