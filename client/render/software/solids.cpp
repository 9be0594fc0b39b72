#include "client/render/software/solids.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <glm/gtc/packing.hpp>

#include "client/render/software/lanes.h"
#include "common/base/for_each.h"
#include "pointreel/cpu.h"

namespace pointreel {
namespace {

float from_half(std::uint16_t half) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(half) << 13) * 0x1p112f;
}

glm::vec3 color_of_instance(const Instance& one) {
  return {from_half(one.color.x), from_half(one.color.y), from_half(one.color.z)};
}

/// Diffuse light from near the eye, and ambient light so that nothing is black (common.glsl).
float light_on(const glm::vec3& normal, const PictureView& view) {
  const float diffuse = std::max(glm::dot(normal, glm::vec3(view.light)), 0.0f);
  return view.light.w * (0.4f + 0.6f * diffuse) + (1.0f - view.light.w);
}

/// The normal of an element, turned towards the eye if its sign is unknown; 0 if all of it is.
glm::vec3 known_normal(const Instance& one, const glm::vec3& from_eye, const PictureView& view) {
  const glm::vec3 n = glm::vec3(one.normal) / 32767.0f;
  if (!(glm::dot(n, n) > 0.25f)) return glm::vec3(0.0f);
  return view.pixel.y > 0.5f && glm::dot(n, from_eye) > 0.0f ? -n : n;
}

std::int16_t bounded(float v, float most) {
  return static_cast<std::int16_t>(v > 0.0f ? (v < most ? v : most) : 0.0f);
}

struct Projection {
  glm::vec3 right, up, forward, shift;
  explicit Projection(const PictureView& view) {
    const glm::mat4& m = view.to_clip;
    const auto row = [&m](int i) { return glm::vec3(m[0][i], m[1][i], m[2][i]); };
    right = row(0);
    up = row(1);
    forward = row(3);
    shift = {m[3][0], m[3][1], m[3][3]};
  }
};

/// The number of an element: its block, its place in the block, and the axis of the face.
constexpr std::uint32_t kNothing = ~0u;
std::uint32_t element(std::uint32_t block, std::uint16_t at) { return (block << 12 | at) << 2; }

}  // namespace

struct Solids::Tile {
  PixelRect pixels;
  TilePlane depth;
  std::array<std::uint32_t, std::tuple_size_v<TilePlane>> elements;
};

void Solids::add_square(const Instance& point, float size, const PictureView& view, Block& block) {
  const Projection p(view);
  const glm::vec3& center = point.center;
  const float w = glm::dot(p.forward, center) + p.shift.z;
  const glm::vec2 clip(glm::dot(p.right, center) + p.shift.x,
                       glm::dot(p.up, center) + p.shift.y);
  if (!(w >= view.eye.w) || std::max(std::abs(clip.x), std::abs(clip.y)) > w) return;
  const glm::vec2 at = 0.5f * glm::vec2(view.window) * (clip / w + 1.0f);
  const glm::vec2 low = glm::ceil(at - 0.5f * size - 0.5f), high = glm::ceil(at + 0.5f * size - 0.5f);
  const TileRect rect{bounded(low.x, view.window.x), bounded(low.y, view.window.y),
                      bounded(high.x, view.window.x), bounded(high.y, view.window.y)};
  if (rect.x0 >= rect.x1 || rect.y0 >= rect.y1) return;
  const glm::vec3 from_eye = center - glm::vec3(view.eye);
  glm::vec3 normal = known_normal(point, from_eye, view);
  if (normal == glm::vec3(0.0f)) {
    const float away = glm::length(from_eye);
    normal = away > 0.0f ? -from_eye / away : glm::vec3(view.light);
  }
  block.squares.push_back(
      {view.eye.w / w, color_of_instance(point) * light_on(normal, view), rect});
}

void Solids::add_cube(const Instance& voxel, const PictureView& view, Block& block) {
  const Projection p(view);
  const float near = view.eye.w;
  const glm::vec3 from_eye = voxel.center - glm::vec3(view.eye);
  const float w = glm::dot(p.forward, voxel.center) + p.shift.z;
  // No cube is drawn smaller than a pixel, so that none falls between the centres of pixels.
  const float half = std::max(voxel.radius, 0.5f * view.pixel.x * w);
  const float reach = 1.73206f * half;
  if (!(w + reach >= near)) return;
  glm::vec2 low(0.0f), high(view.window);
  if (w - reach >= near) {
    low = glm::vec2(1e30f);
    high = glm::vec2(-1e30f);
    const glm::vec3 clip(glm::dot(p.right, voxel.center) + p.shift.x,
                         glm::dot(p.up, voxel.center) + p.shift.y, w);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::vec3 d(corner & 1 ? half : -half, corner & 2 ? half : -half,
                        corner & 4 ? half : -half);
      const glm::vec2 at = glm::vec2(clip.x + glm::dot(p.right, d), clip.y + glm::dot(p.up, d)) /
                           (w + glm::dot(p.forward, d));
      low = glm::min(low, at);
      high = glm::max(high, at);
    }
    low = 0.5f * glm::vec2(view.window) * (low + 1.0f);
    high = 0.5f * glm::vec2(view.window) * (high + 1.0f);
  }
  // One row and column more than the pixels whose centres are inside, against rounding: the rays
  // decide.
  const TileRect rect{bounded(std::floor(low.x - 0.5f), view.window.x),
                      bounded(std::floor(low.y - 0.5f), view.window.y),
                      bounded(std::ceil(high.x + 0.5f), view.window.x),
                      bounded(std::ceil(high.y + 0.5f), view.window.y)};
  if (rect.x0 >= rect.x1 || rect.y0 >= rect.y1) return;
  const glm::vec3 normal = known_normal(voxel, from_eye, view);
  const glm::vec3 color = color_of_instance(voxel);
  Cube cube{from_eye, half, {}, rect};
  for (int axis = 0; axis < 3; ++axis) {
    glm::vec3 face(0.0f);
    face[axis] = from_eye[axis] <= 0.0f ? 1.0f : -1.0f;
    cube.colors[axis] = color * light_on(normal == glm::vec3(0.0f) ? face : normal, view);
  }
  block.cubes.push_back(cube);
}

void Solids::draw_squares(std::uint32_t block, int tile, Tile& to) const {
  const Block& from = blocks_[block];
  for (const std::uint16_t* i = from.bins.begin(tile); i != from.bins.end(tile); ++i) {
    const Square& square = from.squares[*i];
    const int x0 = std::max<int>(square.rect.x0, to.pixels.min.x) - to.pixels.min.x,
              x1 = std::min<int>(square.rect.x1, to.pixels.max.x) - to.pixels.min.x,
              y0 = std::max<int>(square.rect.y0, to.pixels.min.y) - to.pixels.min.y,
              y1 = std::min<int>(square.rect.y1, to.pixels.max.y) - to.pixels.min.y;
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) {
        const auto at = static_cast<std::size_t>(y * kTileStride + x);
        if (!(square.depth > to.depth[at])) continue;
        to.depth[at] = square.depth;
        to.elements[at] = element(block, *i);
      }
  }
}

namespace {


/// A ray along a plane never meets it, but infinity would make NaNs.
POINTREEL_INLINE Lanes inverse(const Lanes& v) { return 1.0f / (v == 0.0f ? 1e-20f : v); }

/// Draws a cube into the planes of a tile. A ray enters the cube at the last of the three planes on
/// the side of the eye, unless it has left through one of the other three before.
POINTREEL_INLINE void cast_cube(const glm::vec3& center, float half_edge, const TileRect& rect,
                                std::uint32_t number, const PictureView& view, const PixelRect& pixels,
                                float* depths, std::uint32_t* elements) {
  const int x0 = std::max<int>(rect.x0, pixels.min.x), x1 = std::min<int>(rect.x1, pixels.max.x),
            y0 = std::max<int>(rect.y0, pixels.min.y), y1 = std::min<int>(rect.y1, pixels.max.y);
  const float near = view.eye.w;
  const glm::vec3 ray_x(view.ray_x);
  for (int y = y0; y < y1; ++y) {
    const glm::vec3 row_ray = glm::vec3(view.ray_corner) +
                              (static_cast<float>(y) + 0.5f) * glm::vec3(view.ray_y);
    for (int x = x0; x < x1; x += kLaneStep) {
      const Lanes column = kIota + (static_cast<float>(x) + 0.5f);
      const Lanes ix = inverse(row_ray.x + column * ray_x.x),
                   iy = inverse(row_ray.y + column * ray_x.y),
                   iz = inverse(row_ray.z + column * ray_x.z);
      const Lanes mx = center.x * ix, my = center.y * iy, mz = center.z * iz;
      const Lanes hx = half_edge * max_of(ix, -ix), hy = half_edge * max_of(iy, -iy),
                   hz = half_edge * max_of(iz, -iz);
      const Lanes ex = mx - hx, ey = my - hy, ez = mz - hz;
      const Lanes enter = max_of(max_of(ex, ey), ez);
      const Lanes leave = min_of(min_of(mx + hx, my + hy), mz + hz);
      const auto at = static_cast<std::size_t>((y - pixels.min.y) * kTileStride + x - pixels.min.x);
      Lanes old;
      load(old, depths + at);
      const Lanes depth = near / enter;
      const LaneMask visible = (enter <= leave) & (enter >= near) & (depth > old);
      store(depths + at, visible ? depth : old);
      const auto first = static_cast<std::int32_t>(number);
      const LaneMask axis = ex == enter ? LaneMask{} : (ey == enter ? LaneMask{} + 1 : LaneMask{} + 2);
      LaneMask numbers;
      std::memcpy(&numbers, elements + at, sizeof(numbers));
      numbers = visible ? axis + first : numbers;
      std::memcpy(elements + at, &numbers, sizeof(numbers));
    }
  }
}

}  // namespace

void Solids::draw_cubes(std::uint32_t block, int tile, const PictureView& view, Tile& to) const {
  const Block& from = blocks_[block];
  struct Kernels {
    static void portable(const Block& from, std::uint32_t block, int tile, const PictureView& view,
                         Tile& to) {
      run(from, block, tile, view, to);
    }
    POINTREEL_AVX2 static void avx2(const Block& from, std::uint32_t block, int tile,
                                    const PictureView& view, Tile& to) {
      run(from, block, tile, view, to);
    }
    POINTREEL_INLINE static void run(const Block& from, std::uint32_t block, int tile,
                                     const PictureView& view, Tile& to) {
      for (const std::uint16_t* i = from.bins.begin(tile); i != from.bins.end(tile); ++i) {
        const Cube& cube = from.cubes[*i];
        cast_cube(cube.center, cube.half_edge, cube.rect, element(block, *i), view, to.pixels,
                  to.depth.data(), to.elements.data());
      }
    }
  };
  const bool avx2 = (cpu_features() & kCpuAvx2) != 0;
  (avx2 ? Kernels::avx2 : Kernels::portable)(from, block, tile, view, to);
}

glm::vec3 Solids::color_of(std::uint32_t number, bool cubes) const {
  const Block& block = blocks_[number >> 14];
  const std::size_t at = number >> 2 & 4095u;
  return cubes ? block.cubes[at].colors[number & 3u] : block.squares[at].color;
}

void Solids::draw(std::span<const Instance> instances, bool cubes, float point_size,
                  const PictureView& view, const Executor& executor, Picture& picture) {
  const std::size_t count = (instances.size() + kBlock - 1) / kBlock;
  if (blocks_.size() < count) blocks_.resize(count);
  for_each(executor, static_cast<int>(count), [&](int i) {
    const std::size_t begin = static_cast<std::size_t>(i) * kBlock;
    Block& block = blocks_[static_cast<std::size_t>(i)];
    block.cubes.clear();
    block.squares.clear();
    for (const Instance& one :
         instances.subspan(begin, std::min(kBlock, instances.size() - begin)))
      cubes ? add_cube(one, view, block) : add_square(one, point_size, view, block);
    block.bins.sort(cubes ? block.cubes.size() : block.squares.size(), picture.grid,
                    [&](std::size_t k) {
                      return cubes ? block.cubes[k].rect : block.squares[k].rect;
                    });
  });
  const SrgbTables& srgb = SrgbTables::get();
  for_each(executor, picture.grid.count(), [&](int tile) {
    Tile to;
    bool any = false;
    for (std::size_t i = 0; i < count; ++i) {
      if (blocks_[i].bins.begin(tile) == blocks_[i].bins.end(tile)) continue;
      if (!any) {
        to.pixels = picture.grid.pixels(tile);
        to.depth.fill(0.0f);
        to.elements.fill(kNothing);
        any = true;
      }
      const auto block = static_cast<std::uint32_t>(i);
      cubes ? draw_cubes(block, tile, view, to) : draw_squares(block, tile, to);
    }
    if (!any) return;
    picture.busy[static_cast<std::size_t>(tile)] = 1;
    for (int y = to.pixels.min.y; y < to.pixels.max.y; ++y) {
      for (int x = to.pixels.min.x; x < to.pixels.max.x; ++x) {
        const auto at = static_cast<std::size_t>((y - to.pixels.min.y) * kTileStride + x -
                                                 to.pixels.min.x);
        if (to.elements[at] == kNothing) continue;
        const std::size_t pixel = picture.index(x, y);
        picture.depths[pixel] = to.depth[at];
        picture.colors[pixel] = srgb.encode(color_of(to.elements[at], cubes), kDrawn);
      }
    }
  });
}

}  // namespace pointreel
