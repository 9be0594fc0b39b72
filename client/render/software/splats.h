#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/instance.h"
#include "client/render/software/bounded.h"
#include "client/render/software/tile.h"
#include "client/render/view.h"
#include "pointreel/executor.h"

namespace pointreel {

/// The image of a surfel's disc as an ellipse. The disc is small in the picture, so its projection
/// is approximated as affine (instancing/pull/surfel_sprite.glsl).
struct alignas(64) EllipseSplat {
  float x, y;     ///< middle, in window coordinates
  float a, b, c;  ///< the square of the distance from the middle is a dx^2 + b dx dy + c dy^2, and
                  ///< 1 at the rim
  float depth;    ///< at the middle: near plane / depth
  float depth_x, depth_y;  ///< its change per pixel
  float depth_reach;       ///< its largest change
  float push;              ///< factor on the depth that moves the disc back by its radius
  glm::vec3 color;         ///< linear, lit
  std::uint32_t normal;    ///< unpack_normal gives it
  TileRect rect;
};
static_assert(sizeof(EllipseSplat) == 64);

/// A unit vector in 30 bits. What is not a number becomes some direction.
inline std::uint32_t pack_normal(float x, float y, float z) {
  const auto bits = [](float v) {
    return static_cast<std::uint32_t>(bounded(511.0f * v + 512.5f, 0.0f, 1023.0f));
  };
  return bits(x) | bits(y) << 10 | bits(z) << 20;
}
inline glm::vec3 unpack_normal(std::uint32_t packed) {
  const auto part = [packed](int shift) {
    return static_cast<float>(static_cast<int>(packed >> shift & 1023u) - 512);
  };
  return glm::vec3(part(0), part(10), part(20)) / 511.0f;
}

/// A disc that is drawn exactly, by intersecting rays: one that is large, or close to the eye.
struct DiscSplat {
  glm::vec3 center;  ///< relative to the eye
  float facing;      ///< normal . center, < 0
  glm::vec3 normal;
  float inverse_square;  ///< of the radius
  glm::vec3 color;       ///< linear, lit
  float push;
  TileRect rect;
};

/// The back of a surfel as a square, which hides what lies behind it (reconstruction.h).
struct BackSplat {
  float depth;
  TileRect rect;
};

/// A part of the surfels of a picture, and the tiles that they touch. Surfels that are not visible
/// are left out.
struct SplatBlock {
  std::vector<EllipseSplat> ellipses;  ///< room for all instances of a block
  std::size_t ellipse_count = 0;       ///< how many of them are in use
  std::vector<DiscSplat> discs;
  std::vector<BackSplat> backs;
  TileBins ellipse_bins, disc_bins, back_bins;
};

/// How surfels become splats.
struct SplatSetup {
  float scale = 1.0f;        ///< factor for the radii
  std::uint32_t one_in = 0;  ///< one in this many surfels keeps its back; 0: none
  bool in_order = false;     ///< draw all as discs, which keep the order of the surfels
  bool normals = false;      ///< ellipses get their normals, which are undefined otherwise
};

/// Surfels in a picture, in blocks.
class Splats {
 public:
  static constexpr std::size_t kBlock = 4096;  ///< instances for each block

  void set(std::span<const Instance> instances, const PictureView& view, const TileGrid& grid,
           const SplatSetup& setup, const Executor& executor);

  std::span<const SplatBlock> blocks() const { return {blocks_.data(), count_}; }

 private:
  std::vector<SplatBlock> blocks_;  ///< the first count_ are in use; memory is kept
  std::size_t count_ = 0;
};

}  // namespace pointreel
