#include "client/render/software/splats.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "client/render/hole_rules.h"
#include "client/render/software/lanes.h"
#include "common/base/for_each.h"
#include "pointreel/cpu.h"

namespace pointreel {
namespace {

/// The largest radius of an ellipse, as a share of its depth, and the least half axes of its image,
/// in pixels: as in instancing/pull/mark.glsl and surfel_sprite.vert.glsl.
constexpr float kNearestEllipse = 0.015f;
constexpr float kLeastRadius = 0.7f, kLeastThickness = 0.05f;

/// A group of instances, one in each lane. Those behind the last repeat it.
struct Group {
  Lanes x, y, z, radius, nx, ny, nz, red, green, blue;
};

POINTREEL_INLINE Lanes from_half(const LaneMask& half) {
  // Moves the bits to where a float has them, and mends the exponent. Correct for small numbers,
  // too, and for all colours, which are not negative.
  return std::bit_cast<Lanes>(half << 13) * 0x1p112f;
}

/// The places, radii and normals of instances by their numbers, the first `count` of `picked`.
POINTREEL_INLINE void gather(Lanes& x, Lanes& y, Lanes& z, Lanes& radius, LaneMask& nx,
                             LaneMask& ny, LaneMask& nz, const Instance* instances,
                             const std::uint16_t* picked, std::size_t count) {
  for (std::size_t k = 0; k < kLanes; ++k) {
    const Instance& one = instances[picked[std::min(k, count - 1)]];
    x[k] = one.center.x;
    y[k] = one.center.y;
    z[k] = one.center.z;
    radius[k] = one.radius;
    nx[k] = one.normal.x;
    ny[k] = one.normal.y;
    nz[k] = one.normal.z;
  }
}

/// All of them.
POINTREEL_INLINE void gather(Group& g, const Instance* instances, const std::uint16_t* picked,
                             std::size_t count) {
  LaneMask nx, ny, nz, red, green, blue;
  gather(g.x, g.y, g.z, g.radius, nx, ny, nz, instances, picked, count);
  for (std::size_t k = 0; k < kLanes; ++k) {
    const Instance& one = instances[picked[std::min(k, count - 1)]];
    red[k] = one.color.x;
    green[k] = one.color.y;
    blue[k] = one.color.z;
  }
  const float unit = 1.0f / 32767.0f;
  g.nx = __builtin_convertvector(nx, Lanes) * unit;
  g.ny = __builtin_convertvector(ny, Lanes) * unit;
  g.nz = __builtin_convertvector(nz, Lanes) * unit;
  g.red = from_half(red);
  g.green = from_half(green);
  g.blue = from_half(blue);
}

POINTREEL_INLINE void sqrt_of(Lanes& v) {
  for (int k = 0; k < kLaneStep; ++k) v[k] = __builtin_sqrtf(v[k]);
}

POINTREEL_INLINE Lanes dot(const glm::vec3& v, const Lanes& x, const Lanes& y, const Lanes& z) {
  return v.x * x + v.y * y + v.z * z;
}

/// A pseudo-random number that depends only on the position (shaders/back.vert.glsl).
POINTREEL_INLINE std::uint32_t hash(const glm::vec3& place) {
  std::uint32_t h = std::bit_cast<std::uint32_t>(place.x) * 0x9e3779b1u ^
                    std::bit_cast<std::uint32_t>(place.y) * 0x85ebca77u ^
                    std::bit_cast<std::uint32_t>(place.z) * 0xc2b2ae3du;
  h = (h ^ h >> 15) * 0x2c1b3c6du;
  h = (h ^ h >> 12) * 0x297a2d39u;
  return h ^ h >> 15;
}

/// The pixels whose centres lie in a rectangle, cut off at the picture. Empty ones have x0 >= x1.
TileRect pixels_in(float x0, float y0, float x1, float y1, const glm::vec2& size) {
  // The comparisons are written so that a NaN becomes 0.
  const auto clamp = [](float v, float most) { return v > 0.0f ? (v < most ? v : most) : 0.0f; };
  return {static_cast<std::int16_t>(std::ceil(clamp(x0 - 0.5f, size.x))),
          static_cast<std::int16_t>(std::ceil(clamp(y0 - 0.5f, size.y))),
          static_cast<std::int16_t>(std::floor(clamp(x1 + 0.5f, size.x))),
          static_cast<std::int16_t>(std::floor(clamp(y1 + 0.5f, size.y)))};
}

/// The first pixel whose centre is not below a coordinate, cut off at 0 and `size`.
POINTREEL_INLINE LaneMask first_pixel(const Lanes& from, float size) {
  // The order of the arguments makes a NaN 0.
  const Lanes at = min_of(max_of(from - 0.5f, Lanes{}), Lanes{} + size);
  const LaneMask whole = __builtin_convertvector(at, LaneMask);
  return whole - (__builtin_convertvector(whole, Lanes) < at);  // true is -1
}

/// The pixel behind the last whose centre is not above a coordinate, cut off at 0 and `size`.
POINTREEL_INLINE LaneMask end_pixel(const Lanes& to, float size) {
  return __builtin_convertvector(min_of(max_of(to + 0.5f, Lanes{}), Lanes{} + size), LaneMask);
}

bool is_empty(const TileRect& rect) { return rect.x0 >= rect.x1 || rect.y0 >= rect.y1; }

/// What the splats of a block are made from, beside the instances.
struct Setup {
  const PictureView& view;
  SplatSetup splats;
  glm::vec3 right, up, forward;  ///< rows of the matrix: the gradients of clip coordinates
  glm::vec3 shift;               ///< their constant parts
  float left_length, top_length;

  Setup(const PictureView& the_view, const SplatSetup& setup) : view(the_view), splats(setup) {
    const glm::mat4& m = view.to_clip;
    const auto row = [&m](int i) { return glm::vec3(m[0][i], m[1][i], m[2][i]); };
    right = row(0);
    up = row(1);
    forward = row(3);
    shift = {m[3][0], m[3][1], m[3][3]};
    left_length = glm::length(forward + right);
    top_length = glm::length(forward + up);
  }
};

/// Adds the exact disc of one surfel.
void add_disc(const Setup& setup, const glm::vec3& center, const glm::vec3& normal, float radius,
              float push, const glm::vec3& color, SplatBlock& block) {
  const PictureView& view = setup.view;
  const float facing = glm::dot(normal, center);
  if (!(facing < 0.0f) || !(radius > 0.0f)) return;
  // A square around the disc, cut off at the near plane.
  glm::vec3 u =
      glm::cross(std::abs(normal.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0), normal);
  u = u * (radius / glm::length(u));
  const glm::vec3 v = glm::cross(normal, u);
  const glm::vec3 corners[4] = {center - u - v, center + u - v, center + u + v, center - u + v};
  const float near = view.eye.w;
  glm::vec2 low(1e30f), high(-1e30f);
  const auto reach = [&](const glm::vec3& p) {
    const float w = std::max(glm::dot(setup.forward, p), near);
    const glm::vec2 at = 0.5f * glm::vec2(view.window) *
                         (glm::vec2(glm::dot(setup.right, p), glm::dot(setup.up, p)) / w + 1.0f);
    low = glm::min(low, at);
    high = glm::max(high, at);
  };
  for (int i = 0; i < 4; ++i) {
    const glm::vec3 &a = corners[i], &b = corners[(i + 1) % 4];
    const float wa = glm::dot(setup.forward, a), wb = glm::dot(setup.forward, b);
    if (wa >= near) reach(a);
    if ((wa < near) != (wb < near)) reach(a + (near - wa) / (wb - wa) * (b - a));
  }
  const TileRect rect = pixels_in(low.x, low.y, high.x, high.y, glm::vec2(view.window));
  if (is_empty(rect)) return;
  block.discs.push_back({center, facing, normal, 1.0f / (radius * radius), color, push, rect});
}

/// Adds the splats of up to eight instances, none of which shows its back.
POINTREEL_INLINE void add_fronts(const Setup& setup, const Instance* instances,
                                 const std::uint16_t* picked, std::size_t count,
                                 SplatBlock& block) {
  const PictureView& view = setup.view;
  const float scale = setup.splats.scale, near = view.eye.w;
  const glm::vec3 eye(view.eye), light(view.light);
  Group g;
  gather(g, instances, picked, count);

  const Lanes fx = g.x - eye.x, fy = g.y - eye.y, fz = g.z - eye.z;  // from the eye
  const Lanes away2 = fx * fx + fy * fy + fz * fz;
  Lanes away = away2;
  sqrt_of(away);
  const Lanes inverse_away = 1.0f / max_of(away, Lanes{} + 1e-30f);
  const Lanes clip_x = dot(setup.right, g.x, g.y, g.z) + setup.shift.x;
  const Lanes clip_y = dot(setup.up, g.x, g.y, g.z) + setup.shift.y;
  const Lanes w = dot(setup.forward, g.x, g.y, g.z) + setup.shift.z;

  // The normal. If its sign is unknown, it is turned towards the eye; if all of it is, it is the
  // direction to the eye.
  const Lanes n2 = g.nx * g.nx + g.ny * g.ny + g.nz * g.nz;
  const LaneMask known = n2 > 0.25f;
  Lanes facing = g.nx * fx + g.ny * fy + g.nz * fz;
  const bool signs_unknown = view.pixel.y > 0.5f;
  Lanes length = n2;
  sqrt_of(length);
  Lanes to_unit = 1.0f / max_of(length, Lanes{} + 1e-30f);
  if (signs_unknown) to_unit = facing > 0.0f ? -to_unit : to_unit;
  const Lanes nx = known ? g.nx * to_unit : -fx * inverse_away;
  const Lanes ny = known ? g.ny * to_unit : -fy * inverse_away;
  const Lanes nz = known ? g.nz * to_unit : -fz * inverse_away;
  facing = nx * fx + ny * fy + nz * fz;

  // Which are visible, and how they are drawn.
  const Lanes reach = 1.41422f * scale * g.radius;
  const Lanes abs_x = max_of(clip_x, -clip_x), abs_y = max_of(clip_y, -clip_y);
  const LaneMask in_view = (w + reach >= near) & (abs_x - w <= reach * setup.left_length) &
                           (abs_y - w <= reach * setup.top_length);
  const LaneMask is_ellipse =
      (w >= near) & (reach <= kNearestEllipse * w) & (setup.splats.in_order ? 0 : -1);

  const Lanes lit = nx * light.x + ny * light.y + nz * light.z;
  const Lanes shade = view.light.w * (0.4f + 0.6f * max_of(lit, Lanes{})) + (1.0f - view.light.w);
  const Lanes red = g.red * shade, green = g.green * shade, blue = g.blue * shade;

  // The gradients of window coordinates, and with them the image of the disc.
  const Lanes inverse_w = 1.0f / max_of(w, Lanes{} + 1e-30f);
  const Lanes half_width = (0.5f * view.window.x) * inverse_w;
  const Lanes half_height = (0.5f * view.window.y) * inverse_w;
  const Lanes across = clip_x * inverse_w, along = clip_y * inverse_w;
  const Lanes xx = half_width * (setup.right.x - across * setup.forward.x);
  const Lanes xy = half_width * (setup.right.y - across * setup.forward.y);
  const Lanes xz = half_width * (setup.right.z - across * setup.forward.z);
  const Lanes yx = half_height * (setup.up.x - along * setup.forward.x);
  const Lanes yy = half_height * (setup.up.y - along * setup.forward.y);
  const Lanes yz = half_height * (setup.up.z - along * setup.forward.z);
  const Lanes slope_x = nx * xx + ny * xy + nz * xz, slope_y = nx * yx + ny * yy + nz * yz;
  const Lanes radius2 = scale * scale * g.radius * g.radius;
  Lanes c_xx = radius2 * (xx * xx + xy * xy + xz * xz - slope_x * slope_x);
  const Lanes c_xy = radius2 * (xx * yx + xy * yy + xz * yz - slope_x * slope_y);
  Lanes c_yy = radius2 * (yx * yx + yy * yy + yz * yz - slope_y * slope_y);
  const Lanes half_trace = 0.5f * (c_xx + c_yy), half_gap = 0.5f * (c_xx - c_yy);
  Lanes half_difference = half_gap * half_gap + c_xy * c_xy;
  sqrt_of(half_difference);
  const Lanes more =
      max_of(max_of(kLeastRadius * kLeastRadius - (half_trace + half_difference),
                    kLeastThickness * kLeastThickness - (half_trace - half_difference)),
             Lanes{});
  c_xx += more;
  c_yy += more;
  const Lanes inverse_det = 1.0f / (c_xx * c_yy - c_xy * c_xy);
  Lanes extent_x = c_xx, extent_y = c_yy;
  sqrt_of(extent_x);
  sqrt_of(extent_y);
  const Lanes middle_x = (0.5f * view.window.x) * (across + 1.0f);
  const Lanes middle_y = (0.5f * view.window.y) * (along + 1.0f);
  const Lanes share = scale * g.radius / max_of(away, Lanes{} + near);  // of the distance
  const Lanes push = 1.0f / (1.0f + hole_rules::kDepthTolerance * share);
  const Lanes depth = near * inverse_w;
  // On a plane, 1 / depth is linear in the picture: (n . ray) / (n . center).
  const Lanes change = depth * w / min_of(facing, Lanes{} - 1e-30f);
  const glm::vec3 ray_x(view.ray_x), ray_y(view.ray_y);
  const Lanes depth_x = change * (nx * ray_x.x + ny * ray_x.y + nz * ray_x.z);
  const Lanes depth_y = change * (nx * ray_y.x + ny * ray_y.y + nz * ray_y.z);
  const Lanes depth_reach = depth * share;
  const Lanes conic_a = c_yy * inverse_det, conic_b = -2.0f * c_xy * inverse_det,
              conic_c = c_xx * inverse_det;

  const LaneMask x0 = first_pixel(middle_x - extent_x, view.window.x),
                 y0 = first_pixel(middle_y - extent_y, view.window.y),
                 x1 = first_pixel(middle_x + extent_x, view.window.x),
                 y1 = first_pixel(middle_y + extent_y, view.window.y);
  const LaneMask added = in_view & is_ellipse & (x0 < x1) & (y0 < y1);
  const LaneMask discs = in_view & ~is_ellipse;
  EllipseSplat* out = &block.ellipses[block.ellipse_count];
  for (std::size_t k = 0; k < std::min(count, kLanes); ++k) {
    // Whether it stays is hard to predict, so it is written first, and perhaps overwritten.
    *out = {middle_x[k],
            middle_y[k],
            conic_a[k],
            conic_b[k],
            conic_c[k],
            depth[k],
            depth_x[k],
            depth_y[k],
            depth_reach[k],
            push[k],
            {red[k], green[k], blue[k]},
            setup.splats.normals ? pack_normal(nx[k], ny[k], nz[k]) : 0,
            {static_cast<std::int16_t>(x0[k]), static_cast<std::int16_t>(y0[k]),
             static_cast<std::int16_t>(x1[k]), static_cast<std::int16_t>(y1[k])}};
    out -= added[k];
    if (discs[k] != 0)
      add_disc(setup, {fx[k], fy[k], fz[k]}, {nx[k], ny[k], nz[k]}, scale * g.radius[k], push[k],
               {red[k], green[k], blue[k]}, block);
  }
  block.ellipse_count = static_cast<std::size_t>(out - block.ellipses.data());
}

/// Adds the backs of up to eight surfels, which keep them.
POINTREEL_INLINE void add_backs(const Setup& setup, const Instance* instances,
                                const std::uint16_t* picked, std::size_t count, SplatBlock& block) {
  const PictureView& view = setup.view;
  const float near = view.eye.w, width = view.window.x, height = view.window.y;
  Lanes x, y, z, radius;
  LaneMask nx, ny, nz;
  gather(x, y, z, radius, nx, ny, nz, instances, picked, count);

  const Lanes w = dot(setup.forward, x, y, z) + setup.shift.z;
  const Lanes clip_x = dot(setup.right, x, y, z) + setup.shift.x;
  const Lanes clip_y = dot(setup.up, x, y, z) + setup.shift.y;
  const Lanes fx = x - view.eye.x, fy = y - view.eye.y, fz = z - view.eye.z;
  Lanes away = fx * fx + fy * fy + fz * fz;
  sqrt_of(away);
  // A surfel that is seen at an angle gets a square as narrow as it looks, to keep outlines in
  // place.
  const Lanes sine = (__builtin_convertvector(nx, Lanes) / 32767.0f * fx +
                      __builtin_convertvector(ny, Lanes) / 32767.0f * fy +
                      __builtin_convertvector(nz, Lanes) / 32767.0f * fz) /
                     away;
  // As OpenGL does, a square whose middle is not in the picture is left out.
  const LaneMask seen =
      (w >= near) & (max_of(clip_x, -clip_x) <= w) & (max_of(clip_y, -clip_y) <= w) & (sine > 0.0f);
  const float reach =
      2.0f * hole_rules::kReach * std::sqrt(static_cast<float>(setup.splats.one_in));
  const Lanes half =
      0.5f *
      min_of(max_of(reach * radius * sine / (view.pixel.x * w), Lanes{} + 1.0f), Lanes{} + 1024.0f);
  const Lanes middle_x = (0.5f * width) * (clip_x / w + 1.0f);
  const Lanes middle_y = (0.5f * height) * (clip_y / w + 1.0f);
  const LaneMask x0 = first_pixel(middle_x - half, width), x1 = end_pixel(middle_x + half, width),
                 y0 = first_pixel(middle_y - half, height), y1 = end_pixel(middle_y + half, height);
  const Lanes tolerance = hole_rules::kBackTolerance * radius / max_of(away, Lanes{} + near);
  const Lanes depth = near / w / (1.0f + tolerance);
  const LaneMask added = seen & (x0 < x1) & (y0 < y1);
  for (std::size_t k = 0; k < std::min(count, kLanes); ++k) {
    if (added[k] == 0) continue;
    block.backs.push_back({depth[k],
                           {static_cast<std::int16_t>(x0[k]), static_cast<std::int16_t>(y0[k]),
                            static_cast<std::int16_t>(x1[k]), static_cast<std::int16_t>(y1[k])}});
  }
}

POINTREEL_INLINE void add_all(const Setup& setup, std::span<const Instance> instances,
                              SplatBlock& block) {
  // Those that show their backs take a fraction of the work.
  std::array<std::uint16_t, Splats::kBlock> fronts, backs;
  std::size_t front_count = 0, back_count = 0;
  const glm::vec3 eye(setup.view.eye);
  const bool signs_unknown = setup.view.pixel.y > 0.5f;
  constexpr float kKnown = 0.25f * 32767.0f * 32767.0f;
  for (std::size_t i = 0; i < instances.size(); ++i) {
    const glm::vec3 normal(instances[i].normal);
    const bool is_back = !signs_unknown && glm::dot(normal, normal) > kKnown &&
                         glm::dot(normal, instances[i].center - eye) >= 0.0f;
    fronts[front_count] = backs[back_count] = static_cast<std::uint16_t>(i);
    front_count += is_back ? 0 : 1;
    back_count += is_back ? 1 : 0;
  }
  const std::uint32_t one_in = setup.splats.one_in;
  std::size_t kept = 0;
  for (std::size_t i = 0; one_in != 0 && i < back_count; ++i) {
    backs[kept] = backs[i];
    kept += hash(instances[backs[i]].center) % one_in == 0 ? 1 : 0;
  }
  for (std::size_t i = 0; i < front_count; i += kLanes)
    add_fronts(setup, instances.data(), &fronts[i], front_count - i, block);
  for (std::size_t i = 0; i < kept; i += kLanes)
    add_backs(setup, instances.data(), &backs[i], kept - i, block);
}

void add_portable(const Setup& setup, std::span<const Instance> instances, SplatBlock& block) {
  add_all(setup, instances, block);
}

POINTREEL_AVX2 void add_avx2(const Setup& setup, std::span<const Instance> instances,
                             SplatBlock& block) {
  add_all(setup, instances, block);
}

template <class Splat>
void sort(const std::vector<Splat>& splats, std::size_t count, const TileGrid& grid,
          TileBins& bins) {
  bins.sort(count, grid, [&](std::size_t i) { return splats[i].rect; });
}

}  // namespace

void Splats::set(std::span<const Instance> instances, const PictureView& view, const TileGrid& grid,
                 const SplatSetup& setup, const Executor& executor) {
  count_ = (instances.size() + kBlock - 1) / kBlock;
  if (blocks_.size() < count_) blocks_.resize(count_);
  const Setup shared(view, setup);
  const bool avx2 = (cpu_features() & kCpuAvx2) != 0;
  for_each(executor, static_cast<int>(count_), [&](int i) {
    const std::size_t begin = static_cast<std::size_t>(i) * kBlock;
    const auto part = instances.subspan(begin, std::min(kBlock, instances.size() - begin));
    SplatBlock& block = blocks_[static_cast<std::size_t>(i)];
    block.ellipses.resize(kBlock);
    block.ellipse_count = 0;
    block.discs.clear();
    block.backs.clear();
    (avx2 ? add_avx2 : add_portable)(shared, part, block);
    sort(block.ellipses, block.ellipse_count, grid, block.ellipse_bins);
    sort(block.discs, block.discs.size(), grid, block.disc_bins);
    sort(block.backs, block.backs.size(), grid, block.back_bins);
  });
}

}  // namespace pointreel
