#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/instance.h"
#include "client/render/software/picture.h"
#include "client/render/software/tile.h"
#include "client/render/view.h"
#include "client/scene/draw_options.h"
#include "pointreel/executor.h"

namespace pointreel {

/// Bounds on the edges of points, in pixels.
struct PointSizes {
  float least, most;
};

/// Draws voxels and points: opaque elements of which the nearest is seen in each pixel. A pixel
/// first gets the number of its element, and its colour once all are drawn (Pfister et al.,
/// Surfels, section 7.5: shading comes after visibility).
class Solids {
 public:
  /// Draws into a picture whose colours are the background and whose depths are 0. `cubes`: draws
  /// voxels, else squares. Writes the picture's normals if it has room for them.
  void draw(std::span<const Instance> instances, bool cubes, PointSizes sizes,
            const PictureView& view, const Executor& executor, Picture& picture);

 private:
  static constexpr std::size_t kBlock = 4096;  ///< instances for each block

  /// A cube, as the ray through each pixel meets it (instancing/pull/voxel_sprite.frag.glsl).
  struct Cube {
    glm::vec3 center;  ///< relative to the eye
    float half_edge;
    TileRect rect;
    std::uint16_t instance;  ///< in its block
  };
  /// A point (point.frag.glsl).
  struct Square {
    glm::vec2 middle;  ///< in the picture
    float depth;       ///< of the middle
    float half;        ///< half the edge, in pixels
    TileRect rect;
    std::uint16_t instance;  ///< in its block
  };
  struct Block {
    std::vector<Cube> cubes;
    std::vector<Square> squares;
    TileBins bins;
  };
  struct Tile;
  class Setup;

  void draw_cubes(std::uint32_t block, int tile, const PictureView& view, Tile& to) const;
  void draw_squares(std::uint32_t block, int tile, const PictureView& view, Tile& to) const;

  std::vector<Block> blocks_;
};

}  // namespace pointreel
