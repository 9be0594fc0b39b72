#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace pointreel {

/// The Delaunay triangulation of a few points in a plane whose coordinates are integers, so that
/// all decisions are exact.
///
/// Where four or more points lie on a circle, as on every grid, the diagonals start at the point
/// with the lowest index. The triangulation is then unique, and two sets that share these points in
/// the same order agree on it.
///
/// Points are added from left to right, and edges are flipped until they are locally Delaunay. C.
/// L. Lawson, "Software for C1 surface interpolation", 1977. Keeps its buffers between calls.
class Delaunay {
 public:
  /// No coordinate is larger, in either direction: an in-circle test then fits into 64 bits.
  static constexpr int kReach = 8191;
  /// Edges are kept in 16 bits, and there are up to eight for each point.
  static constexpr std::size_t kMostPoints = 4096;

  /// The indices of the corners, counterclockwise.
  using Triangle = std::array<std::uint16_t, 3>;

  /// Triangulates no more than kMostPoints points. Of points that coincide, all but the first are
  /// left out. There are no triangles if all points lie on a line. The result is valid until the
  /// next call.
  std::span<const Triangle> run(std::span<const glm::ivec2> points);

 private:
  /// An edge of a triangle: four times the triangle's index plus that of the edge, from 0 to 2. The
  /// edge runs from the corner of the same index to the next one.
  using Edge = std::uint16_t;
  static constexpr Edge kNone = 0xffff;
  struct Corner {
    std::uint16_t point;
    Edge twin;  ///< of the edge that starts here; kNone at the rim
  };

  Edge add(std::uint16_t a, std::uint16_t b, std::uint16_t c);
  void join(Edge one, Edge other);
  void start(std::size_t chain, std::uint16_t point);
  void insert(std::uint16_t point, std::uint16_t before);
  void legalize();

  std::span<const glm::ivec2> points_;
  std::vector<std::uint64_t> order_;
  std::vector<std::uint16_t> sorted_;
  std::vector<Corner> corners_;  ///< of the triangles, four for each, of which the last is unused
  std::size_t size_ = 0;         ///< of `corners_`, as far as it is in use
  std::vector<Triangle> triangles_;
  std::vector<Edge> open_;  ///< edges opposite to the new point that may have to be flipped
  /// The rim, counterclockwise: for each of its points the next and the last one, and the edge to
  /// the next.
  std::vector<std::uint16_t> next_, last_;
  std::vector<Edge> rim_;
};

}  // namespace pointreel
