#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "pointreel/cloud.h"

namespace pointreel {

/// p -> to + rotation * (p - from).
struct RigidMotion {
  glm::vec3 from{0.0f}, to{0.0f};
  glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f};

  glm::vec3 operator()(const glm::vec3& p) const { return to + rotation * (p - from); }
};

/// The cell of a grid that a position lies in, as a key. Cells beyond 2^20 share those at the
/// border.
struct GridCell {
  static GridCell at(const glm::vec3& in_cells);
  GridCell neighbor(int corner) const;  ///< towards +x, +y and +z, by the bits of `corner`

  std::int32_t x = 0, y = 0, z = 0;
  bool operator==(const GridCell&) const = default;
  struct Hash {
    std::size_t operator()(const GridCell& cell) const;
  };
};

/// A surface as small, about flat pieces: the points of a cell that face about the same way.
struct SurfacePieces {
  struct Piece {
    glm::vec3 position{0.0f};  ///< the mean of its points
    glm::vec3 normal{0.0f};    ///< of unit length; zero if its points disagree
    float points = 0.0f;
  };

  float cell = 0.0f;  ///< edge of a cell
  std::vector<Piece> pieces;
  /// The pieces in a cell: one, or two that face opposite ways.
  std::unordered_map<GridCell, std::array<std::optional<std::uint32_t>, 2>, GridCell::Hash> in_cell;
  std::vector<std::uint32_t> of_point;  ///< the piece of each point, or of each finer piece
};

/// The piece nearest to a position, within the eight cells around it and `reach`, whose normal is
/// at an angle with at least this cosine to `normal`; nothing if there is none.
std::optional<std::uint32_t> nearest_piece(const SurfacePieces& pieces, const glm::vec3& position,
                                           const glm::vec3& normal, float least_cosine,
                                           float reach);

/// The pieces of a surface, fine to coarse.
struct SurfacePyramid {
  glm::dvec3 origin{0.0};  ///< what positions are relative to
  std::vector<SurfacePieces> levels;
};

/// `cloud` has normals. `cell`: of the finest pieces, above 0. O(points).
SurfacePyramid surface_pyramid(const PointCloud& cloud, float cell);

/// How the surface moves from one frame to another around each point of the first, in coordinates
/// relative to the second's origin: `positions` are relative to that of the first, and only
/// translated by the difference of both. Nothing where the surface of the second frame does not
/// continue the first's: where it is further away than `tolerance` (root mean square), or is not
/// there.
///
/// Each part of the surface moves rigidly, and blends with its neighbours. Parts are found coarse
/// to fine, each level beginning with the motion of the one above, by steps that minimise the
/// distances between pieces and the planes of those nearest to them that face the same way (Y.
/// Chen, G. Medioni, "Object modelling by registration of multiple range images", 1992, section 4).
/// Along directions in which a surface can slide on itself, parts follow those around them. Motions
/// of up to about the size of the coarsest pieces are found.
std::vector<std::optional<RigidMotion>> surface_motion(const SurfacePyramid& from,
                                                       const std::vector<glm::vec3>& positions,
                                                       const SurfacePyramid& to, float tolerance);

}  // namespace pointreel
