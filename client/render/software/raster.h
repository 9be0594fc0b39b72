#pragma once

#include <glm/glm.hpp>

#include "client/render/software/splats.h"
#include "client/render/software/tile.h"
#include "client/render/view.h"

namespace pointreel {

/// The pixels of a tile while splats are added to it. Planes are in the tile's own coordinates.
struct SplatTile {
  PixelRect pixels;  ///< of the picture
  TilePlane depth;   ///< reversed
  TilePlane red, green, blue, weight;
  TilePlane normal_x, normal_y, normal_z;  ///< only with sum_normals
};

/// How `blend` treats depths.
enum class BlendDepth {
  none,   ///< neither tested nor kept, except by what is blended last
  test,   ///< only what is not behind is blended
  write,  ///< the same, and its depth is kept
};

/// Draws the splats of a block into a tile. Splats are drawn in their order, the ellipses before
/// the discs. The functions of all versions give the same results.
struct SplatKernels {
  /// The first pass: depths, pushed back; of fronts and of backs.
  void (*depth)(const SplatBlock& block, int tile, const PictureView& view, SplatTile& to);
  /// The second pass of normalized splatting: sums of weighted colours and of weights, of what is
  /// not behind the depths.
  void (*sum)(const SplatBlock& block, int tile, const PictureView& view, SplatTile& to);
  /// The same, and sums of weighted normals.
  void (*sum_normals)(const SplatBlock& block, int tile, const PictureView& view, SplatTile& to);
  /// The same as `sum`, but colours are blended over each other, with the weights as opacities.
  /// `weight` is how much of the background they cover.
  void (*blend)(const SplatBlock& block, int tile, const PictureView& view, BlendDepth how,
                SplatTile& to);
};

/// The version for this processor.
const SplatKernels& splat_kernels();

}  // namespace pointreel
