#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/region.h"
#include "common/surface/lanes.h"

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
  /// `rects` are the pixels that at most 65,536 elements cover, within the picture.
  void sort(const std::vector<TileRect>& rects, const TileGrid& grid) {
    begin_.assign(static_cast<std::size_t>(grid.count()) + 1, 0);
    const auto each = [&](const TileRect& rect, const auto& visit) {
      const int last_x = (rect.x1 - 1) / kTileWidth, last_y = (rect.y1 - 1) / kTileHeight;
      for (int y = rect.y0 / kTileHeight; y <= last_y; ++y)
        for (int x = rect.x0 / kTileWidth; x <= last_x; ++x)
          visit(static_cast<std::size_t>(y * grid.tiles.x + x));
    };
    for (const TileRect& rect : rects) each(rect, [&](std::size_t tile) { ++begin_[tile]; });
    std::uint32_t total = 0;
    for (std::uint32_t& begin : begin_) {
      total += begin;
      begin = total;  // the end of the tile's list, which is filled from its end
    }
    elements_.resize(total);
    for (std::size_t i = rects.size(); i-- > 0;)
      each(rects[i], [&](std::size_t tile) {
        elements_[--begin_[tile]] = static_cast<std::uint16_t>(i);
      });
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
