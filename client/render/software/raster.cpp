#include "client/render/software/raster.h"

#include <algorithm>

#include "client/render/software/lanes.h"
#include "pointreel/cpu.h"

namespace pointreel {
namespace {

POINTREEL_INLINE bool any_of(const LaneMask& mask) {
  std::int64_t parts[4];
  std::memcpy(parts, &mask, sizeof(parts));
  return (parts[0] | parts[1] | parts[2] | parts[3]) != 0;
}

/// exp(-4.5 d2) for d2 from 0 to 1: FORMULAS.md, "Surfel mask". Taylor's polynomial of the fourth
/// root around the middle, wrong by less than 1e-4 of the value.
POINTREEL_INLINE Lanes gaussian(const Lanes& d2) {
  const Lanes t = d2 * -1.125f + 0.5625f;
  const Lanes root =
      0.5697828f * (1.0f + t * (1.0f + t * (0.5f + t * (1.0f / 6.0f + t * (1.0f / 24.0f)))));
  const Lanes square = root * root;
  return square * square;
}

/// The part of an element within a tile, in the tile's coordinates.
struct Part {
  int x0, x1, y0, y1;
};

POINTREEL_INLINE Part part_of(const TileRect& rect, const PixelRect& pixels) {
  return {std::max<int>(rect.x0 - pixels.min.x, 0),
          std::min<int>(rect.x1, pixels.max.x) - pixels.min.x,
          std::max<int>(rect.y0 - pixels.min.y, 0),
          std::min<int>(rect.y1, pixels.max.y) - pixels.min.y};
}

/// Calls visit(at, inside, d2, depth) for each group of pixels of an ellipse: where it is in the
/// tile's planes, which of the pixels are on the disc, the squares of their distances from its
/// middle, and the depths of the disc there.
template <class Visit>
POINTREEL_INLINE void each_group(const EllipseSplat& splat, const PixelRect& pixels,
                                 const Visit& visit) {
  const Part part = part_of(splat.rect, pixels);
  const float first_x = static_cast<float>(pixels.min.x + part.x0) + 0.5f - splat.x;
  for (int y = part.y0; y < part.y1; ++y) {
    const float dy = static_cast<float>(pixels.min.y + y) + 0.5f - splat.y;
    const float b = splat.b * dy, c = splat.c * dy * dy, depth_y = splat.depth_y * dy;
    Lanes dx = kIota + first_x;
    const std::size_t row = static_cast<std::size_t>(y * kTileStride);
    for (int x = part.x0; x < part.x1; x += kLaneStep) {
      const Lanes d2 = dx * (splat.a * dx + b) + c;
      const Lanes change = splat.depth_x * dx + depth_y;
      const Lanes depth = splat.depth + max_of(min_of(change, Lanes{} + splat.depth_reach),
                                               Lanes{} - splat.depth_reach);
      visit(row + static_cast<std::size_t>(x), d2 <= 1.0f, d2, depth);
      dx += static_cast<float>(kLaneStep);
    }
  }
}

/// The same for an exact disc.
template <class Visit>
POINTREEL_INLINE void each_group(const DiscSplat& splat, const PictureView& view,
                                 const PixelRect& pixels, const Visit& visit) {
  const Part part = part_of(splat.rect, pixels);
  const float near = view.eye.w;
  const glm::vec3 ray_x(view.ray_x);
  for (int y = part.y0; y < part.y1; ++y) {
    const glm::vec3 row_ray = glm::vec3(view.ray_corner) +
                              (static_cast<float>(pixels.min.y + y) + 0.5f) * glm::vec3(view.ray_y);
    const std::size_t row = static_cast<std::size_t>(y * kTileStride);
    for (int x = part.x0; x < part.x1; x += kLaneStep) {
      const Lanes column = kIota + (static_cast<float>(pixels.min.x + x) + 0.5f);
      const Lanes rx = row_ray.x + column * ray_x.x, ry = row_ray.y + column * ray_x.y,
                  rz = row_ray.z + column * ray_x.z;
      const Lanes w =
          splat.facing / (splat.normal.x * rx + splat.normal.y * ry + splat.normal.z * rz);
      const Lanes dx = w * rx - splat.center.x, dy = w * ry - splat.center.y,
                  dz = w * rz - splat.center.z;
      const Lanes d2 = (dx * dx + dy * dy + dz * dz) * splat.inverse_square;
      visit(row + static_cast<std::size_t>(x), (d2 <= 1.0f) & (w >= near), d2, near / w);
    }
  }
}

/// Pixels beyond the end of a row are in the tile's margin, where nobody looks.
template <class Visit>
POINTREEL_INLINE void each_splat(const SplatBlock& block, int tile, const PictureView& view,
                                 const PixelRect& pixels, const Visit& visit) {
  for (const std::uint16_t* i = block.ellipse_bins.begin(tile); i != block.ellipse_bins.end(tile);
       ++i) {
    const EllipseSplat& splat = block.ellipses[*i];
    each_group(splat, pixels,
               [&](std::size_t at, const LaneMask& inside, const Lanes& d2, const Lanes& depth) {
                 visit(splat, at, inside, d2, depth);
               });
  }
  for (const std::uint16_t* i = block.disc_bins.begin(tile); i != block.disc_bins.end(tile); ++i) {
    const DiscSplat& splat = block.discs[*i];
    each_group(splat, view, pixels,
               [&](std::size_t at, const LaneMask& inside, const Lanes& d2, const Lanes& depth) {
                 visit(splat, at, inside, d2, depth);
               });
  }
}

POINTREEL_INLINE void draw_depth(const SplatBlock& block, int tile, const PictureView& view,
                                 SplatTile& to) {
  float* depths = to.depth.data();
  each_splat(block, tile, view, to.pixels,
             [&](const auto& splat, std::size_t at, const LaneMask& inside, const Lanes&,
                 const Lanes& depth) {
               Lanes old;
               load(old, depths + at);
               const Lanes pushed = depth * splat.push;
               store(depths + at, (inside & (pushed > old)) ? pushed : old);
             });
  for (const std::uint16_t* i = block.back_bins.begin(tile); i != block.back_bins.end(tile); ++i) {
    const BackSplat& splat = block.backs[*i];
    const Part part = part_of(splat.rect, to.pixels);
    const Lanes depth = Lanes{} + splat.depth;
    for (int y = part.y0; y < part.y1; ++y) {
      for (int x = part.x0; x < part.x1; x += kLaneStep) {
        float* const at = depths + static_cast<std::size_t>(y * kTileStride + x);
        Lanes old;
        load(old, at);
        const LaneMask inside = kIota < static_cast<float>(part.x1 - x);
        store(at, (inside & (depth > old)) ? depth : old);
      }
    }
  }
}

POINTREEL_INLINE glm::vec3 normal_of(const EllipseSplat& splat) {
  return unpack_normal(splat.normal);
}
POINTREEL_INLINE glm::vec3 normal_of(const DiscSplat& splat) { return splat.normal; }

template <bool kNormals>
POINTREEL_INLINE void draw_sum(const SplatBlock& block, int tile, const PictureView& view,
                               SplatTile& to) {
  const auto add = [](float* plane, const Lanes& value) POINTREEL_INLINED {
    Lanes sum;
    load(sum, plane);
    store(plane, sum + value);
  };
  each_splat(block, tile, view, to.pixels,
             [&](const auto& splat, std::size_t at, const LaneMask& inside, const Lanes& d2,
                 const Lanes& depth) {
               const glm::vec3& color = splat.color;
               Lanes nearest;
               load(nearest, to.depth.data() + at);
               const LaneMask visible = inside & (depth > nearest);
               if (!any_of(visible)) return;
               const Lanes weight = visible ? gaussian(d2) : Lanes{};
               add(to.red.data() + at, weight * color.r);
               add(to.green.data() + at, weight * color.g);
               add(to.blue.data() + at, weight * color.b);
               add(to.weight.data() + at, weight);
               if constexpr (kNormals) {
                 const glm::vec3 normal = normal_of(splat);
                 add(to.normal_x.data() + at, weight * normal.x);
                 add(to.normal_y.data() + at, weight * normal.y);
                 add(to.normal_z.data() + at, weight * normal.z);
               }
             });
}

POINTREEL_INLINE void draw_blend(const SplatBlock& block, int tile, const PictureView& view,
                                 BlendDepth how, SplatTile& to) {
  const auto mix = [](float* plane, const Lanes& opacity, const Lanes& value) POINTREEL_INLINED {
    Lanes old;
    load(old, plane);
    store(plane, old + opacity * (value - old));
  };
  each_splat(block, tile, view, to.pixels,
             [&](const auto& splat, std::size_t at, const LaneMask& inside, const Lanes& d2,
                 const Lanes& depth) {
               const glm::vec3& color = splat.color;
               Lanes old;
               load(old, to.depth.data() + at);
               const LaneMask visible =
                   how == BlendDepth::none ? inside : LaneMask(inside & (depth > old));
               if (!any_of(visible)) return;
               const Lanes opacity = visible ? gaussian(d2) : Lanes{};
               mix(to.red.data() + at, opacity, Lanes{} + color.r);
               mix(to.green.data() + at, opacity, Lanes{} + color.g);
               mix(to.blue.data() + at, opacity, Lanes{} + color.b);
               mix(to.weight.data() + at, opacity, Lanes{} + 1.0f);
               if (how != BlendDepth::test) store(to.depth.data() + at, visible ? depth : old);
             });
}

void depth_portable(const SplatBlock& block, int tile, const PictureView& view, SplatTile& to) {
  draw_depth(block, tile, view, to);
}
void sum_portable(const SplatBlock& block, int tile, const PictureView& view, SplatTile& to) {
  draw_sum<false>(block, tile, view, to);
}
void sum_normals_portable(const SplatBlock& block, int tile, const PictureView& view,
                          SplatTile& to) {
  draw_sum<true>(block, tile, view, to);
}
void blend_portable(const SplatBlock& block, int tile, const PictureView& view, BlendDepth how,
                    SplatTile& to) {
  draw_blend(block, tile, view, how, to);
}

POINTREEL_AVX2 void depth_avx2(const SplatBlock& block, int tile, const PictureView& view,
                               SplatTile& to) {
  draw_depth(block, tile, view, to);
}
POINTREEL_AVX2 void sum_avx2(const SplatBlock& block, int tile, const PictureView& view,
                             SplatTile& to) {
  draw_sum<false>(block, tile, view, to);
}
POINTREEL_AVX2 void sum_normals_avx2(const SplatBlock& block, int tile, const PictureView& view,
                                     SplatTile& to) {
  draw_sum<true>(block, tile, view, to);
}
POINTREEL_AVX2 void blend_avx2(const SplatBlock& block, int tile, const PictureView& view,
                               BlendDepth how, SplatTile& to) {
  draw_blend(block, tile, view, how, to);
}

}  // namespace

const SplatKernels& splat_kernels() {
  static constexpr SplatKernels kPortable{depth_portable, sum_portable, sum_normals_portable,
                                          blend_portable};
  static constexpr SplatKernels kAvx2{depth_avx2, sum_avx2, sum_normals_avx2, blend_avx2};
  return (cpu_features() & kCpuAvx2) != 0 ? kAvx2 : kPortable;
}

}  // namespace pointreel
