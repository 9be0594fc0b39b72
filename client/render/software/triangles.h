#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/instance.h"
#include "client/render/scene_strips.h"
#include "client/render/software/picture.h"
#include "client/render/software/tile.h"
#include "client/render/view.h"
#include "pointreel/executor.h"

namespace pointreel {

/// Draws triangle strips, with colours and normals interpolated between the vertices, and a light
/// for each pixel. What is visible is decided first, and then each pixel is shaded once. Keeps its
/// buffers between pictures.
class Triangles {
 public:
  /// Triangles that are seen from behind. If the signs of normals are unknown, all are drawn alike.
  enum class Backs {
    none,   ///< they are left out
    depth,  ///< what they hide is not drawn, and neither are they: a hole is in front of them
  };

  /// Draws into the colours and depths of a picture, and into its normals if it has room for them.
  /// `vertices` are those of the strips; `strips`
  /// also has representative surfels, which are drawn as pixels. Triangles that reach the near
  /// plane are left out.
  void draw(std::span<const Instance> vertices, const SceneStrips& strips, Backs backs,
            const PictureView& view, const Executor& executor, Picture& picture);

 private:
  /// A vertex in the picture: window coordinates, and reversed depth, 0 if it is not in front of
  /// the near plane.
  struct Projected {
    float x, y, depth;
  };
  /// The vertices of a triangle; of a point, three times the same number, counted from the first
  /// point.
  struct Triangle {
    std::uint32_t a, b, c;
    bool is_back;
    TileRect rect;
  };
  struct Block {
    std::vector<Triangle> triangles;  ///< the first `count` are in use
    std::size_t count = 0;
    TileBins bins;
    const SceneStrips::Part* part = nullptr;
    std::span<const StripCut::Range> ranges;
    std::size_t first_point = 0, end_point = 0;
  };
  struct Tile;

  std::size_t divide(const SceneStrips& strips, Backs backs);
  void project(std::span<const Instance> vertices, const PictureView& view,
               std::vector<Projected>& to, const Executor& executor) const;
  void set_up(Backs backs, const PictureView& view, Block& block) const;
  void draw_tile(std::size_t block, int tile, Tile& to) const;

  std::vector<Projected> projected_, points_;
  std::vector<Block> blocks_;
};

}  // namespace pointreel
