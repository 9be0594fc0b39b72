#include "client/render/software/solids.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <glm/gtc/packing.hpp>

#include "client/render/software/flat_light.h"
#include "client/render/software/lanes.h"
#include "common/base/for_each.h"
#include "pointreel/cpu.h"

namespace pointreel {
namespace {

/// The normal of an element, turned towards the eye if its sign is unknown; 0 if all of it is.
glm::vec3 known_normal(const Instance& one, const glm::vec3& from_eye, const PictureView& view) {
  const glm::vec3 n = glm::vec3(one.normal) / 32767.0f;
  if (!(glm::dot(n, n) > 0.25f)) return glm::vec3(0.0f);
  return view.pixel.y > 0.5f && glm::dot(n, from_eye) > 0.0f ? -n : n;
}

/// How far the light tells the faces of a cube apart (voxel.glsl).
float sides_of(const glm::vec3& center, float half, const PictureView& view) {
  const float w = (view.to_clip * glm::vec4(center, 1.0f)).w;
  return glm::smoothstep(2.0f, 8.0f, 2.0f * half / (view.pixel.x * std::max(w, view.eye.w)));
}

/// The normal of an element that a pixel shows, and the light on it.
struct Shown {
  glm::vec3 normal;
  float light;
};

/// `face`: the axis across the face of a voxel.
Shown shown_of(const Instance& one, bool is_cube, std::uint32_t face, const PictureView& view) {
  const glm::vec3 from_eye = one.center - glm::vec3(view.eye);
  glm::vec3 normal = known_normal(one, from_eye, view);
  if (normal != glm::vec3(0.0f)) return {normal, light_on(normal, view)};
  const float away = glm::length(from_eye);
  const glm::vec3 to_eye = away > 0.0f ? -from_eye / away : glm::vec3(view.light);
  if (!is_cube) return {to_eye, light_on(to_eye, view)};
  const int axis = static_cast<int>(face);
  normal[axis] = from_eye[axis] <= 0.0f ? 1.0f : -1.0f;
  return {normal, light_on(glm::mix(to_eye, normal, sides_of(one.center, one.radius, view)), view)};
}

std::int16_t bounded(float v, float most) {
  return static_cast<std::int16_t>(v > 0.0f ? (v < most ? v : most) : 0.0f);
}

/// The pixels whose centres lie between two coordinates, or less than `more` outside of them.
TileRect pixels_between(const glm::vec2& low, const glm::vec2& high, float more,
                        const glm::vec2& size) {
  const glm::vec2 from = glm::ceil(low - (0.5f + more)), to = glm::ceil(high - (0.5f - more));
  return {bounded(from.x, size.x), bounded(from.y, size.y), bounded(to.x, size.x),
          bounded(to.y, size.y)};
}

bool is_empty(const TileRect& rect) { return rect.x0 >= rect.x1 || rect.y0 >= rect.y1; }

/// The number of an element: its block, its place in the block, and the axis of the face.
constexpr std::uint32_t kNothing = ~0u;
std::uint32_t element(std::uint32_t block, std::uint16_t at) { return (block << 12 | at) << 2; }

}  // namespace

struct Solids::Tile {
  PixelRect pixels;
  TilePlane depth;
  std::array<std::uint32_t, std::tuple_size_v<TilePlane>> elements;
};

/// Projects instances of a picture.
class Solids::Setup {
 public:
  explicit Setup(const PictureView& view) : view_(view) {
    const glm::mat4& m = view.to_clip;
    const auto row = [&m](int i) { return glm::vec3(m[0][i], m[1][i], m[2][i]); };
    right_ = row(0);
    up_ = row(1);
    forward_ = row(3);
    shift_ = {m[3][0], m[3][1], m[3][3]};
  }

  void add_square(const Instance& point, std::uint16_t number, PointSizes sizes,
                  Block& block) const {
    const glm::vec3 clip = to_clip(point.center);
    const float w = clip.z;
    if (!(w >= view_.eye.w) || std::max(std::abs(clip.x), std::abs(clip.y)) > w) return;
    const glm::vec2 at = in_window(glm::vec2(clip) / w);
    const float size =
        std::clamp(2.0f * point.radius / (view_.pixel.x * w), sizes.least, sizes.most);
    const TileRect rect =
        pixels_between(at - 0.5f * size, at + 0.5f * size, 0.0f, glm::vec2(view_.window));
    if (!is_empty(rect)) block.squares.push_back({at, w, 0.5f * size, rect, number});
  }

  void add_cube(const Instance& voxel, std::uint16_t number, Block& block) const {
    const float near = view_.eye.w;
    const glm::vec3 clip = to_clip(voxel.center);
    const float w = clip.z;
    // No cube is drawn smaller than a pixel, so that none falls between the centres of pixels.
    const float half = std::max(voxel.radius, 0.5f * view_.pixel.x * w);
    const float reach = 1.73206f * half;
    if (!(w + reach >= near)) return;
    glm::vec2 low(0.0f), high(view_.window);
    if (w - reach >= near) {
      // The box around the image, from the slopes of the projection at the centre. The nearest
      // corner looks larger.
      const glm::vec2 middle = glm::vec2(clip) / w;
      const glm::vec3 x = glm::abs(right_ - middle.x * forward_),
                      y = glm::abs(up_ - middle.y * forward_);
      const glm::vec2 extent = 0.5f * glm::vec2(view_.window) * half / (w - reach) *
                               glm::vec2(x.x + x.y + x.z, y.x + y.y + y.z);
      low = in_window(middle) - extent;
      high = in_window(middle) + extent;
    }
    const TileRect rect = pixels_between(low, high, 0.01f, glm::vec2(view_.window));
    if (!is_empty(rect))
      block.cubes.push_back({voxel.center - glm::vec3(view_.eye), half, rect, number});
  }

 private:
  /// x, y and w.
  glm::vec3 to_clip(const glm::vec3& p) const {
    return glm::vec3(glm::dot(right_, p), glm::dot(up_, p), glm::dot(forward_, p)) + shift_;
  }
  glm::vec2 in_window(const glm::vec2& device) const {
    return 0.5f * glm::vec2(view_.window) * (device + 1.0f);
  }

  const PictureView& view_;
  glm::vec3 right_, up_, forward_, shift_;
};

void Solids::draw_squares(std::uint32_t block, int tile, const PictureView& view, Tile& to) const {
  const Block& from = blocks_[block];
  for (const std::uint16_t* i = from.bins.begin(tile); i != from.bins.end(tile); ++i) {
    const Square& square = from.squares[*i];
    const int x0 = std::max<int>(square.rect.x0, to.pixels.min.x) - to.pixels.min.x,
              x1 = std::min<int>(square.rect.x1, to.pixels.max.x) - to.pixels.min.x,
              y0 = std::max<int>(square.rect.y0, to.pixels.min.y) - to.pixels.min.y,
              y1 = std::min<int>(square.rect.y1, to.pixels.max.y) - to.pixels.min.y;
    // The depth grows with the square of the distance from the middle.
    const glm::vec2 first = glm::vec2(to.pixels.min) + 0.5f - square.middle;
    const float fall = view.pixel.x * square.depth / square.half;
    for (int y = y0; y < y1; ++y) {
      const float dy = first.y + static_cast<float>(y);
      for (int x = x0; x < x1; ++x) {
        const auto at = static_cast<std::size_t>(y * kTileStride + x);
        const float dx = first.x + static_cast<float>(x);
        const float depth = view.eye.w / (square.depth + fall * (dx * dx + dy * dy));
        if (!(depth > to.depth[at])) continue;
        to.depth[at] = depth;
        to.elements[at] = element(block, *i);
      }
    }
  }
}

namespace {

/// A ray along a plane never meets it, but infinity would make NaNs.
POINTREEL_INLINE Lanes inverse(const Lanes& v) { return 1.0f / (v == 0.0f ? 1e-20f : v); }

/// Draws a cube into the planes of a tile. A ray enters the cube at the last of the three planes on
/// the side of the eye, unless it has left through one of the other three before.
POINTREEL_INLINE void cast_cube(const glm::vec3& center, float half_edge, const TileRect& rect,
                                std::uint32_t number, const PictureView& view,
                                const PixelRect& pixels, float* depths, std::uint32_t* elements) {
  const int x0 = std::max<int>(rect.x0, pixels.min.x), x1 = std::min<int>(rect.x1, pixels.max.x),
            y0 = std::max<int>(rect.y0, pixels.min.y), y1 = std::min<int>(rect.y1, pixels.max.y);
  const float near = view.eye.w;
  const glm::vec3 ray_x(view.ray_x);
  for (int y = y0; y < y1; ++y) {
    const glm::vec3 row_ray =
        glm::vec3(view.ray_corner) + (static_cast<float>(y) + 0.5f) * glm::vec3(view.ray_y);
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
      const LaneMask axis =
          ex == enter ? LaneMask{} : (ey == enter ? LaneMask{} + 1 : LaneMask{} + 2);
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

void Solids::draw(std::span<const Instance> instances, bool cubes, PointSizes sizes,
                  const PictureView& view, const Executor& executor, Picture& picture) {
  const std::size_t count = (instances.size() + kBlock - 1) / kBlock;
  if (blocks_.size() < count) blocks_.resize(count);
  const Setup setup(view);
  for_each(executor, static_cast<int>(count), [&](int i) {
    const std::size_t begin = static_cast<std::size_t>(i) * kBlock;
    Block& block = blocks_[static_cast<std::size_t>(i)];
    block.cubes.clear();
    block.squares.clear();
    const std::size_t end = std::min(begin + kBlock, instances.size());
    for (std::size_t k = begin; k < end; ++k) {
      const auto number = static_cast<std::uint16_t>(k - begin);
      cubes ? setup.add_cube(instances[k], number, block)
            : setup.add_square(instances[k], number, sizes, block);
    }
    block.bins.sort(
        cubes ? block.cubes.size() : block.squares.size(), picture.grid,
        [&](std::size_t k) { return cubes ? block.cubes[k].rect : block.squares[k].rect; });
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
      cubes ? draw_cubes(block, tile, view, to) : draw_squares(block, tile, view, to);
    }
    if (!any) return;
    picture.busy[static_cast<std::size_t>(tile)] = 1;
    std::uint32_t last = kNothing;
    glm::u8vec4 color{};
    glm::vec3 normal(0.0f);
    for (int y = to.pixels.min.y; y < to.pixels.max.y; ++y) {
      for (int x = to.pixels.min.x; x < to.pixels.max.x; ++x) {
        const auto at =
            static_cast<std::size_t>((y - to.pixels.min.y) * kTileStride + x - to.pixels.min.x);
        const std::uint32_t number = to.elements[at];
        if (number == kNothing) continue;
        const std::size_t pixel = picture.index(x, y);
        picture.depths[pixel] = to.depth[at];
        if (number != last) {
          last = number;
          const std::size_t block = number >> 14, in_block = number >> 2 & 4095u;
          const std::size_t instance = cubes ? blocks_[block].cubes[in_block].instance
                                             : blocks_[block].squares[in_block].instance;
          const Instance& shown = instances[block * kBlock + instance];
          const Shown face = shown_of(shown, cubes, number & 3u, view);
          normal = face.normal;
          color = srgb.encode(color_of_instance(shown) * face.light, kDrawn);
        }
        if (!picture.normals.empty()) picture.normals[pixel] = normal;
        picture.colors[pixel] = color;
      }
    }
  });
}

}  // namespace pointreel
