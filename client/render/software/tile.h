#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/region.h"
#include "codec/surface/lanes.h"

namespace pointreel {

/// The number of lanes as a step for signed coordinates.
inline constexpr int kLaneStep = static_cast<int>(kLanes);

/// Pictures are drawn in tiles, each by one thread, whose buffers stay in its processor's cache.
/// The width and height are multiples of 4, for the sake of hole filling.
inline constexpr int kTileWidth = 64, kTileHeight = 32;
/// Kernels read and write whole groups of lanes, so rows are longer than the tile is wide.
inline constexpr int kTileStride = kTileWidth + kLaneStep;

/// A float for each pixel of a tile.
using TilePlane = std::array<float, static_cast<std::size_t>(kTileStride* kTileHeight)>;

/// The pixels of an element, or the tiles that it touches.
struct TileRect {
  std::int16_t x0, y0, x1, y1;  ///< from the first (included) to the last (excluded)
};

/// How a picture is divided into tiles.
struct TileGrid {
  glm::ivec2 size{0};   ///< of the picture
  glm::ivec2 tiles{0};  ///< in each direction

  TileGrid() = default;
  explicit TileGrid(glm::ivec2 picture)
      : size(picture),
        tiles((picture.x + kTileWidth - 1) / kTileWidth,
              (picture.y + kTileHeight - 1) / kTileHeight) {}

  int count() const { return tiles.x * tiles.y; }
  /// The pixels of a tile.
  PixelRect pixels(int tile) const {
    const glm::ivec2 min(tile % tiles.x * kTileWidth, tile / tiles.x * kTileHeight);
    return {min, glm::min(min + glm::ivec2(kTileWidth, kTileHeight), size)};
  }
};

/// Which elements of a list touch which tile. They keep their order.
class TileBins {
 public:
  /// `rect_of(i)` are the pixels that element i of `count` covers, within the picture. No more than
  /// 65,536 elements.
  template <class RectOf>
  void sort(std::size_t count, const TileGrid& grid, const RectOf& rect_of) {
    begin_.assign(static_cast<std::size_t>(grid.count()) + 1, 0);
    const auto across = static_cast<unsigned>(grid.tiles.x);
    const auto each = [&](const TileRect& rect, const auto& visit) {
      const unsigned first_x = static_cast<unsigned>(rect.x0) / kTileWidth,
                     first_y = static_cast<unsigned>(rect.y0) / kTileHeight,
                     last_x = static_cast<unsigned>(rect.x1 - 1) / kTileWidth,
                     last_y = static_cast<unsigned>(rect.y1 - 1) / kTileHeight;
      if (first_x == last_x && first_y == last_y) {
        visit(first_y * across + first_x);
        return;
      }
      for (unsigned y = first_y; y <= last_y; ++y)
        for (unsigned x = first_x; x <= last_x; ++x) visit(y * across + x);
    };
    for (std::size_t i = 0; i < count; ++i)
      each(rect_of(i), [&](unsigned tile) { ++begin_[tile]; });
    std::uint32_t total = 0;
    for (std::uint32_t& begin : begin_) {
      total += begin;
      begin = total;  // the end of the tile's list, which is filled from its end
    }
    elements_.resize(total);
    for (std::size_t i = count; i-- > 0;)
      each(rect_of(i),
           [&](unsigned tile) { elements_[--begin_[tile]] = static_cast<std::uint16_t>(i); });
  }

  /// The elements that touch a tile.
  const std::uint16_t* begin(int tile) const {
    return elements_.data() + begin_[static_cast<std::size_t>(tile)];
  }
  const std::uint16_t* end(int tile) const {
    return elements_.data() + begin_[static_cast<std::size_t>(tile) + 1];
  }

 private:
  std::vector<std::uint32_t> begin_;  ///< of each tile, and the end of the last
  std::vector<std::uint16_t> elements_;
};

}  // namespace pointreel
