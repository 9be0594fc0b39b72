#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace pointreel {

/// Ends a triangle strip in a list of indices.
inline constexpr std::uint32_t kEndOfStrip = ~std::uint32_t{0};

/// Orders triangles into strips, each followed by kEndOfStrip. In a strip, every three successive
/// indices are a triangle; the second, the fourth and so on are turned around. Each triangle
/// appears once, the way round that it has. Strips begin where triangles have the fewest neighbours
/// left, and follow one another closely, so that their corners are still in a cache of vertices.
/// (P. Reuter, J. Behr, M. Alexa, "An Improved Adjacency Data Structure for Fast Triangle
/// Stripping", 2005, describes such a search.) Keeps its buffers between calls.
class StripOrder {
 public:
  /// Appends the strips of up to 2^14 triangles.
  void run(std::span<const std::array<std::uint32_t, 3>> triangles,
           std::vector<std::uint32_t>& indices);

 private:
  struct Edge {
    std::uint64_t ends;  ///< as a key
    std::uint16_t edge;  ///< three times the triangle's index plus the number of the edge
  };
  void find_neighbors(std::span<const std::array<std::uint32_t, 3>> triangles);
  /// The edge of a triangle that is still to be drawn, across an edge of another; kNone if none is.
  std::uint16_t across(std::uint16_t edge) const;

  static constexpr std::uint16_t kNone = 0xffff;

  std::vector<Edge> edges_;
  std::vector<std::uint16_t> twins_;
  std::vector<std::uint8_t> done_;
};

}  // namespace pointreel
