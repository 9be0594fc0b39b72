#include "client/render/software/screen_shading.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "client/render/software/bounded.h"
#include "client/render/software/lane_vectors.h"
#include "client/render/software/shadow_light.h"
#include "common/base/for_each.h"
#include "pointreel/cpu.h"

namespace pointreel {
namespace {

constexpr float kAround[8][2] = {{1.0f, 0.0f},        {0.7071f, 0.7071f}, {0.0f, 1.0f},
                                 {-0.7071f, 0.7071f}, {-1.0f, 0.0f},      {-0.7071f, -0.7071f},
                                 {0.0f, -1.0f},       {0.7071f, -0.7071f}};

glm::vec3 unit(const glm::vec3& v) {
  return v * (1.0f / std::sqrt(std::max(glm::dot(v, v), 1e-30f)));
}

glm::vec3 pixel_ray(const PictureView& view, int x, int y) {
  return glm::vec3(view.ray_corner) + (static_cast<float>(x) + 0.5f) * glm::vec3(view.ray_x) +
         (static_cast<float>(y) + 0.5f) * glm::vec3(view.ray_y);
}

/// Those of pixels that follow each other in a row.
POINTREEL_INLINE LaneVec rays_of(const PictureView& view, int x, int y) {
  const Lanes middle_x = kIota + (static_cast<float>(x) + 0.5f);
  const float middle_y = static_cast<float>(y) + 0.5f;
  const auto ray = [&](int axis) POINTREEL_INLINED {
    return view.ray_corner[axis] + middle_x * view.ray_x[axis] + middle_y * view.ray_y[axis];
  };
  return {ray(0), ray(1), ray(2)};
}

/// The normal with which a pixel is shaded. Where the surfaces that it shows do not agree, or seem
/// to face away, it is turned towards the eye.
glm::vec3 shading_normal(const glm::vec3& mean, const glm::vec3& to_eye) {
  const float length = std::sqrt(glm::dot(mean, mean));
  const glm::vec3 n = unit(mean + std::max(1.0f - length, 0.0f) * to_eye);
  const float facing = glm::dot(n, to_eye);
  return facing >= kLeastFacing ? n : unit(n + (kLeastFacing - facing) * to_eye);
}

POINTREEL_INLINE LaneVec unit(const LaneVec& v) {
  return (1.0f / root_of(max_of(dot(v, v), Lanes{} + 1e-30f))) * v;
}

/// The same as for one pixel.
POINTREEL_INLINE LaneVec shading_normal(const LaneVec& mean, const LaneVec& to_eye) {
  const Lanes length = root_of(dot(mean, mean));
  const LaneVec n = unit(mean + max_of(1.0f - length, Lanes{}) * to_eye);
  const Lanes facing = dot(n, to_eye);
  return choose(facing >= kLeastFacing, n, unit(n + (kLeastFacing - facing) * to_eye));
}

POINTREEL_INLINE LaneVec diffuse_light(const ShadingView& s, const LaneVec& n) {
  const auto& c = s.diffuse;
  const Lanes xy = n.x * n.y, yz = n.y * n.z, up = 3.0f * n.z * n.z - 1.0f, xz = n.x * n.z,
              across = n.x * n.x - n.y * n.y;
  const auto sum = [&](int i) POINTREEL_INLINED {
    return max_of(c[0][i] + c[1][i] * n.y + c[2][i] * n.z + c[3][i] * n.x + c[4][i] * xy +
                      c[5][i] * yz + c[6][i] * up + c[7][i] * xz + c[8][i] * across,
                  Lanes{});
  };
  return {sum(0), sum(1), sum(2)};
}

/// LightProbe::glossy in eight directions.
POINTREEL_INLINE LaneVec glossy_light(const LightProbe& probe, const LaneVec& d) {
  constexpr int kEdge = LightProbe::kGlossyEdge, kStride = kEdge + 2;
  const auto size_of = [](const Lanes& v) POINTREEL_INLINED { return max_of(v, -v); };
  const auto sign_of = [](const Lanes& v)
                           POINTREEL_INLINED { return v < 0.0f ? Lanes{} - 1.0f : Lanes{} + 1.0f; };
  const Lanes scale = 1.0f / (size_of(d.x) + size_of(d.y) + size_of(d.z));
  const Lanes up_x = scale * d.x, up_y = scale * d.z;
  const Lanes p_x = d.y < 0.0f ? sign_of(up_x) * (1.0f - size_of(up_y)) : up_x,
              p_y = d.y < 0.0f ? sign_of(up_y) * (1.0f - size_of(up_x)) : up_y;
  // In texels, beginning with the middle of the one around the map.
  const Lanes at_x = (0.5f * p_x + 0.5f) * static_cast<float>(kEdge) + 0.5f,
              at_y = (0.5f * p_y + 0.5f) * static_cast<float>(kEdge) + 0.5f;
  LaneVec light{};
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const int x = static_cast<int>(bounded(at_x[lane], 0.0f, kEdge)),
              y = static_cast<int>(bounded(at_y[lane], 0.0f, kEdge));
    const float share_x = at_x[lane] - static_cast<float>(x),
                share_y = at_y[lane] - static_cast<float>(y);
    const glm::vec3 *low = &probe.glossy[static_cast<std::size_t>(y * kStride + x)],
                    *high = low + kStride;
    set_lane(
        light, lane,
        glm::mix(glm::mix(low[0], low[1], share_x), glm::mix(high[0], high[1], share_x), share_y));
  }
  return light;
}

/// Between colours that are at the same distance from each other; linear light.
template <std::size_t kCount>
glm::vec3 ramp(const glm::vec3 (&colors)[kCount], float share) {
  const float at = bounded(share, 0.0f, 1.0f) * static_cast<float>(kCount - 1);
  const std::size_t first = std::min(static_cast<std::size_t>(at), kCount - 2);
  return glm::mix(colors[first], colors[first + 1], at - static_cast<float>(first));
}

/// The colour of a pixel that shows what a surface is like (light.frag.glsl).
glm::vec3 false_color(const ShadingView& s, const PictureView& view, float open, float bend,
                      float depth, const glm::vec3& place, const glm::vec3& ray,
                      const glm::vec3& normal) {
  static constexpr glm::vec3 kBends[] = {{0.02f, 0.10f, 0.45f},
                                         {0.10f, 0.32f, 0.62f},
                                         {0.62f, 0.62f, 0.60f},
                                         {0.85f, 0.40f, 0.10f},
                                         {0.60f, 0.10f, 0.02f}};
  static constexpr glm::vec3 kOpen[] = {{0.01f, 0.01f, 0.03f},
                                        {0.12f, 0.05f, 0.04f},
                                        {0.30f, 0.17f, 0.10f},
                                        {0.56f, 0.40f, 0.27f},
                                        {0.80f, 0.76f, 0.68f}};
  static constexpr glm::vec3 kDepths[] = {{0.98f, 0.80f, 0.02f},
                                          {0.12f, 0.58f, 0.12f},
                                          {0.02f, 0.27f, 0.26f},
                                          {0.05f, 0.08f, 0.25f},
                                          {0.06f, 0.00f, 0.09f}};
  const auto source = static_cast<ColorSource>(static_cast<int>(s.reach.z));
  if (source == ColorSource::curvature) {
    const float scaled = bend * s.reach.y / kHalfBend;
    return ramp(kBends, 0.5f + 0.5f * scaled / (1.0f + std::abs(scaled)));
  }
  if (source == ColorSource::accessibility) return ramp(kOpen, open * open * open);
  if (source == ColorSource::depth)
    return ramp(kDepths, (depth - s.scale.z) / (s.scale.w - s.scale.z));
  // Lines of the same width, from the change of height per pixel on the plane of the surface.
  const float along = std::min(glm::dot(normal, ray), -1e-3f);
  const auto change = [&](const glm::vec3& step) {
    return depth / s.scale.x *
           glm::dot(glm::vec3(s.up), step - glm::dot(normal, step) / along * ray);
  };
  const glm::vec2 slope(change(glm::vec3(view.ray_x)), change(glm::vec3(view.ray_y)));
  const float steep = std::max(std::sqrt(glm::dot(slope, slope)), 1e-6f);
  const float height = (glm::dot(place, glm::vec3(s.up)) + s.scale.y) / s.scale.x;
  const float nearest = std::floor(height + 0.5f);
  const bool strong = std::abs(nearest - 5.0f * std::floor(nearest / 5.0f + 0.5f)) < 0.5f;
  const float line =
      std::clamp((strong ? 1.5f : 1.0f) - std::abs(height - nearest) / steep, 0.0f, 1.0f) *
      std::clamp(2.0f - 5.0f * steep, 0.0f, 1.0f);
  return glm::mix(glm::vec3(0.62f, 0.60f, 0.56f), glm::vec3(0.10f, 0.03f, 0.01f),
                  (strong ? 1.0f : 0.7f) * line);
}

/// How much of the light all around is seen as highlights, scaled by the reflectance and added (B.
/// Karis, "Physically Based Shading on Mobile", 2014).
struct EnvironmentShare {
  Lanes scaled, added;
};
POINTREEL_INLINE EnvironmentShare environment_share(float roughness, const Lanes& facing) {
  const float a = 1.0f - roughness, b = 0.0425f - 0.0275f * roughness;
  // A quotient falls nearly as the power of two of the source does, and is the same everywhere.
  Lanes falling = 1.0f / (1.0f + 0.85f * facing);
  falling *= falling;
  falling *= falling;
  falling *= falling;
  const Lanes share = min_of(Lanes{} + a * a, falling) * a + b;
  return {1.04f - 0.572f * roughness - 1.04f * share, 1.04f * share - 0.04f + 0.022f * roughness};
}

/// The light of the key light that a surface reflects, for 1 that a white diffuse surface would
/// return: B. Walter et al., "Microfacet Models for Refraction through Rough Surfaces", 2007, with
/// the approximations of B. Karis, "Real Shading in Unreal Engine 4", 2013. No cosine is < 0.
POINTREEL_INLINE Lanes highlight_of(float alpha2, const Lanes& half_cosine, const Lanes& facing,
                                    const Lanes& lit, const Lanes& half_facing) {
  const Lanes base = half_cosine * half_cosine * (alpha2 - 1.0f) + 1.0f;
  const float k = 0.5f * std::sqrt(alpha2);
  const Lanes masking = (facing * (1.0f - k) + k) * (lit * (1.0f - k) + k);
  const Lanes away = 1.0f - half_facing;
  const Lanes away2 = away * away;
  const Lanes fresnel = kReflectance + (1.0f - kReflectance) * away2 * away2 * away;
  return 0.25f * alpha2 * fresnel / (base * base * masking);
}

/// The taps of a turn, in lanes.
constexpr std::size_t kTapLanes = (kTaps + kLanes - 1) / kLanes;
struct Taps {
  std::array<Lanes, kTapLanes> x{}, y{};
  std::array<LaneMask, kTapLanes> used{};

  explicit Taps(int turn) {
    for (int i = 0; i < kTaps; ++i) {
      const std::size_t block = static_cast<std::size_t>(i) / kLanes,
                        lane = static_cast<std::size_t>(i) % kLanes;
      const glm::vec2 at = tap(i, turn);
      x[block][lane] = at.x;
      y[block][lane] = at.y;
      used[block][lane] = -1;
    }
  }
};

/// A point of a surface that looks for what surrounds it.
struct Looking {
  glm::ivec2 at;               ///< its pixel
  glm::vec3 place, normal;     ///< relative to the eye
  float most;                  ///< how far it looks, in pixels
  float tolerance;             ///< what is no farther than this above it takes no light
  float near, inverse_reach2;  ///< of the view; one by the square of the reach
};

/// The sum of the light that the surroundings of a point take, as seen by each of its taps.
POINTREEL_INLINE float light_taken(const Looking& from, const Taps& taps, const PictureView& view,
                                   const Picture& picture) {
  const glm::ivec2 size = picture.grid.size;
  const glm::vec3 corner(view.ray_corner), step_x(view.ray_x), step_y(view.ray_y);
  Lanes taken{};
  for (std::size_t block = 0; block < kTapLanes; ++block) {
    const LaneMask x = from.at.x + floor_of(from.most * taps.x[block] + 0.5f),
                   y = from.at.y + floor_of(from.most * taps.y[block] + 0.5f);
    const LaneMask inside = taps.used[block] & (x >= 0) & (y >= 0) & (x < size.x) & (y < size.y);
    // Outside they may be too large to multiply.
    const LaneMask pixel = (y & inside) * size.x + (x & inside);
    Lanes there{};
    for (std::size_t lane = 0; lane < kLanes; ++lane)
      there[lane] = picture.depths[static_cast<std::size_t>(pixel[lane])];
    // In the middle of a pixel.
    const Lanes middle_x = __builtin_convertvector(x, Lanes) + 0.5f,
                middle_y = __builtin_convertvector(y, Lanes) + 0.5f;
    const LaneMask shown = inside & (there > 0.0f);
    const Lanes w = from.near / (shown ? there : Lanes{} + 1.0f);
    const auto away = [&](int axis) POINTREEL_INLINED {
      return w * (corner[axis] + middle_x * step_x[axis] + middle_y * step_y[axis]) -
             from.place[axis];
    };
    const Lanes dx = away(0), dy = away(1), dz = away(2);
    const Lanes distance2 = dx * dx + dy * dy + dz * dz;
    const Lanes above =
        dx * from.normal.x + dy * from.normal.y + dz * from.normal.z - from.tolerance;
    const Lanes near_share = 1.0f - distance2 * from.inverse_reach2;
    const LaneMask takes = shown & (above > 0.0f) & (near_share > 0.0f);
    if (!any_lane(takes)) continue;
    const Lanes share = near_share * above / root_of(distance2 + 1e-30f);
    taken += takes ? share : Lanes{};
  }
  float sum = 0.0f;
  for (std::size_t lane = 0; lane < kLanes; ++lane) sum += taken[lane];
  return sum;
}

float light_taken_portable(const Looking& from, const Taps& taps, const PictureView& view,
                           const Picture& picture) {
  return light_taken(from, taps, view, picture);
}
POINTREEL_AVX2 float light_taken_avx2(const Looking& from, const Taps& taps,
                                      const PictureView& view, const Picture& picture) {
  return light_taken(from, taps, view, picture);
}

/// Light up to kLinear stays, and all light above it fits below 1.
POINTREEL_INLINE Lanes tone(const Lanes& light) {
  constexpr float kLinear = 0.6f;
  const Lanes more = (light - kLinear) / (1.0f - kLinear);
  return light > kLinear ? kLinear + (1.0f - kLinear) * more / (1.0f + more) : light;
}

/// Pixels that follow each other in a row, as they are lit.
struct PixelRow {
  LaneMask shown{};        ///< whether they show anything
  LaneVec ray{}, place{};  ///< from the eye
  LaneVec to_eye{}, normal{};
  LaneVec surface{};  ///< linear colours
  Lanes open{}, bend{};
};

/// Means of the cells around pixels that show the same surface. The first pixel is one on the left
/// of its cell.
POINTREEL_INLINE void find_surroundings(const ShadingCells& cells, int x, int y, const Lanes& depth,
                                        PixelRow& row) {
  Lanes open{}, bend{}, weights{};
  const auto add = [&](const Lanes& cell_depth, const Lanes& cell_open,
                       const Lanes& cell_bend) POINTREEL_INLINED {
    const Lanes apart = cell_depth - depth;
    const Lanes weight = max_of(apart, -apart) < 0.02f * depth ? Lanes{} + 1.0f : Lanes{} + 1e-3f;
    open += weight * cell_open;
    bend += weight * cell_bend;
    weights += weight;
  };
  // The cell of each pixel, and its neighbours on the side of the pixel.
  const auto own = [](const Lanes& from_left) POINTREEL_INLINED {
    return __builtin_shufflevector(from_left, from_left, 1, 1, 2, 2, 3, 3, 4, 4);
  };
  const auto beside = [](const Lanes& from_left) POINTREEL_INLINED {
    return __builtin_shufflevector(from_left, from_left, 0, 2, 1, 3, 2, 4, 3, 5);
  };
  for (const int row_of_cells : {y, (y & 1) != 0 ? y + 2 : y - 2}) {
    const std::size_t left = cells.index(x, row_of_cells) - 1;
    Lanes depths, opens, bends;
    load(depths, &cells.depth[left]);
    load(opens, &cells.open[left]);
    load(bends, &cells.bend[left]);
    add(own(depths), own(opens), own(bends));
    add(beside(depths), beside(opens), beside(bends));
  }
  const Lanes share = 1.0f / weights;
  row.open = open * share;
  row.bend = bend * share;
}

/// Finds where pixels are, how they are turned, and what surrounds them.
POINTREEL_INLINE void place_pixels(const PictureView& view, const Picture& picture,
                                   const ShadingCells& cells, int x, int y, const Lanes& depth,
                                   PixelRow& row) {
  find_surroundings(cells, x, y, depth, row);
  row.ray = rays_of(view, x, y);
  row.place = (view.eye.w / depth) * row.ray;
  row.to_eye = (Lanes{} - 1.0f) * unit(row.ray);
  LaneVec mean = row.to_eye;
  for (std::size_t lane = 0; lane < kLanes; ++lane)
    if (row.shown[lane] != 0)
      set_lane(mean, lane, picture.normals[picture.index(x + static_cast<int>(lane), y)]);
  row.normal = shading_normal(mean, row.to_eye);
}

/// The light that pixels send to the eye.
POINTREEL_INLINE LaneVec light_of(const ShadingView& shading, const LightProbe& probe,
                                  const ShadowMap& shadow, const glm::vec3& eye,
                                  const PixelRow& row) {
  const float roughness = shading.key.w, alpha2 = roughness * roughness * roughness * roughness;
  const glm::vec3 key(shading.key);
  const LaneVec key_direction = all_of(glm::vec3(shading.key_direction));
  const glm::mat3 to_environment(shading.to_environment);
  const LaneVec& normal = row.normal;
  const Lanes facing = max_of(dot(normal, row.to_eye), Lanes{} + 1e-3f);
  const Lanes lit = dot(normal, key_direction);
  LaneVec diffuse = row.open * diffuse_light(shading, turned(to_environment, normal));
  const EnvironmentShare part = environment_share(roughness, facing);
  const LaneVec mirrored = 2.0f * dot(normal, row.to_eye) * normal - row.to_eye;
  LaneVec highlight = row.open * (kReflectance * part.scaled + part.added) *
                      glossy_light(probe, turned(to_environment, mirrored));
  if (key != glm::vec3(0.0f)) {
    Lanes reaches{};
    const LaneMask asks = row.shown & (lit > 0.0f);
    if (any_lane(asks)) {
      const LaneVec there = moved(shading.to_shadow, all_of(eye) + row.place);
      reaches = asks ? lit * light_reaching(shadow, there, shading.key_direction.w) : Lanes{};
    }
    const LaneVec half = unit(row.to_eye + key_direction);
    diffuse = diffuse + reaches * all_of(key);
    const Lanes mirror = highlight_of(alpha2, max_of(dot(normal, half), Lanes{}), facing,
                                      max_of(lit, Lanes{}), dot(row.to_eye, half));
    highlight = highlight + reaches * mirror * all_of(key);
  }
  const LaneVec light = row.surface * diffuse + highlight;
  return {tone(light.x), tone(light.y), tone(light.z)};
}

/// Darkens pixels that show the floor in shadow; `height`: of the eye above it.
POINTREEL_INLINE void shade_floor_row(const ShadingView& shading, const ShadowMap& shadow,
                                      const PictureView& view, float height, const glm::ivec2& x,
                                      int y, Picture& picture) {
  const SrgbTables& srgb = SrgbTables::get();
  const LaneVec eye = all_of(glm::vec3(view.eye)), up = all_of(glm::vec3(shading.up));
  for (int first = x[0]; first < x[1]; first += kLaneStep) {
    const LaneVec ray = rays_of(view, first, y);
    const Lanes down = -dot(ray, up);
    const LaneMask shown = (down > 0.0f) & (kIota < static_cast<float>(x[1] - first));
    if (!any_lane(shown)) continue;
    const LaneVec there =
        moved(shading.to_shadow, eye + (height / (shown ? down : Lanes{} + 1.0f)) * ray);
    const Lanes lit = light_reaching(shadow, there, shading.key_direction.w);
    const LaneMask darker = shown & (lit != 1.0f);
    if (!any_lane(darker)) continue;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      if (darker[lane] == 0) continue;
      glm::u8vec4& color = picture.colors[picture.index(first, y) + lane];
      color = srgb.encode((1.0f - kFloorShadow * (1.0f - lit[lane])) * srgb.decode(color), color.a);
    }
  }
}

struct RowKernels {
  static void place_portable(const PictureView& view, const Picture& picture,
                             const ShadingCells& cells, int x, int y, const Lanes& depth,
                             PixelRow& row) {
    place_pixels(view, picture, cells, x, y, depth, row);
  }
  POINTREEL_AVX2 static void place_avx2(const PictureView& view, const Picture& picture,
                                        const ShadingCells& cells, int x, int y, const Lanes& depth,
                                        PixelRow& row) {
    place_pixels(view, picture, cells, x, y, depth, row);
  }
  static void light_portable(const ShadingView& shading, const LightProbe& probe,
                             const ShadowMap& shadow, const glm::vec3& eye, PixelRow& row) {
    row.surface = light_of(shading, probe, shadow, eye, row);
  }
  POINTREEL_AVX2 static void light_avx2(const ShadingView& shading, const LightProbe& probe,
                                        const ShadowMap& shadow, const glm::vec3& eye,
                                        PixelRow& row) {
    row.surface = light_of(shading, probe, shadow, eye, row);
  }
  static void floor_portable(const ShadingView& shading, const ShadowMap& shadow,
                             const PictureView& view, float height, const glm::ivec2& x, int y,
                             Picture& picture) {
    shade_floor_row(shading, shadow, view, height, x, y, picture);
  }
  POINTREEL_AVX2 static void floor_avx2(const ShadingView& shading, const ShadowMap& shadow,
                                        const PictureView& view, float height, const glm::ivec2& x,
                                        int y, Picture& picture) {
    shade_floor_row(shading, shadow, view, height, x, y, picture);
  }
};

}  // namespace

void ShadingCells::resize(glm::ivec2 picture) {
  size_ = (picture + 1) / 2;
  const std::size_t count = stride() * (static_cast<std::size_t>(size_.y) + 2);
  for (auto* values : {&depth, &open, &bend}) values->resize(count);
}

void ShadingCells::extend_borders() {
  const auto row_length = static_cast<std::ptrdiff_t>(stride());
  for (auto* values : {&depth, &open, &bend}) {
    for (int y = 0; y < size_.y; ++y) {
      float* row = &(*values)[index(0, 2 * y)];
      row[-1] = row[0];
      row[size_.x] = row[size_.x - 1];
    }
    std::copy_n(values->begin() + row_length, row_length, values->begin());
    std::copy_n(values->end() - 2 * row_length, row_length, values->end() - row_length);
  }
}

void ScreenShading::find_open(const ShadingView& shading, const PictureView& view,
                              const Executor& executor, const Picture& picture) {
  const glm::ivec2 size = picture.grid.size;
  cells_.resize(size);
  const std::array<Taps, 4> taps{Taps(0), Taps(1), Taps(2), Taps(3)};
  const auto taken_of = (cpu_features() & kCpuAvx2) != 0 ? light_taken_avx2 : light_taken_portable;
  const bool bends = shading.reach.z == static_cast<float>(ColorSource::curvature);
  const float near = view.eye.w, reach = shading.reach.x, inverse_reach2 = 1.0f / (reach * reach);
  for_each(executor, picture.grid.count(), [&](int tile) {
    const PixelRect pixels = picture.grid.pixels(tile);
    const bool busy = picture.busy[static_cast<std::size_t>(tile)] != 0;
    for (int y = pixels.min.y; y < pixels.max.y; y += 2) {
      for (int x = pixels.min.x; x < pixels.max.x; x += 2) {
        const std::size_t cell = cells_.index(x, y);
        cells_.depth[cell] = 0.0f;
        cells_.open[cell] = 1.0f;
        cells_.bend[cell] = 0.0f;
        if (!busy) continue;
        // The first of the pixels that shows something stands for all.
        glm::ivec2 at(x, y);
        bool any = false;
        for (int i = 0; i < 4 && !any; ++i) {
          at = glm::min(glm::ivec2(x + (i & 1), y + (i >> 1)), size - 1);
          any = picture.is_drawn(at.x, at.y) && picture.depths[picture.index(at.x, at.y)] > 0.0f;
        }
        if (!any) continue;
        const std::size_t pixel = picture.index(at.x, at.y);
        const float depth = picture.depths[pixel], w = near / depth;
        const glm::vec3 ray = pixel_ray(view, at.x, at.y), place = w * ray;
        const glm::vec3 normal = shading_normal(picture.normals[pixel], -unit(ray));
        const float most = std::clamp(reach / (view.pixel.x * w), kLeastReach,
                                      kMostReach * static_cast<float>(size.y));
        // The tolerance covers that depths are those of discs.
        const float tolerance = 0.02f * reach + 2.0f * view.pixel.x * w;
        const int turn = (x / 2 & 1) + 2 * (y / 2 & 1);
        const float taken = taken_of({.at = at,
                                      .place = place,
                                      .normal = normal,
                                      .most = most,
                                      .tolerance = tolerance,
                                      .near = near,
                                      .inverse_reach2 = inverse_reach2},
                                     taps[static_cast<std::size_t>(turn)], view, picture);
        cells_.depth[cell] = depth;
        cells_.open[cell] = std::max(0.0f, 1.0f - kOcclusion / kTaps * taken);
        if (!bends) continue;
        const float far =
            std::clamp(kBend * shading.reach.y / (view.pixel.x * w), kLeastBend, kMostBend);
        const float farthest = 3.0f * far * view.pixel.x * w;
        float bend = 0.0f;
        int count = 0;
        for (const auto& step : kAround) {
          const int there_x = at.x + static_cast<int>(std::floor(far * step[0] + 0.5f)),
                    there_y = at.y + static_cast<int>(std::floor(far * step[1] + 0.5f));
          if (there_x < 0 || there_y < 0 || there_x >= size.x || there_y >= size.y) continue;
          if (!picture.is_drawn(there_x, there_y)) continue;
          const std::size_t other = picture.index(there_x, there_y);
          if (picture.depths[other] == 0.0f) continue;
          const glm::vec3 other_ray = pixel_ray(view, there_x, there_y),
                          away = near / picture.depths[other] * other_ray - place;
          const float distance2 = glm::dot(away, away);
          if (distance2 > farthest * farthest) continue;
          const glm::vec3 change =
              shading_normal(picture.normals[other], -unit(other_ray)) - normal;
          bend += glm::dot(change, away) / std::max(distance2, 1e-30f);
          ++count;
        }
        if (count > 0) cells_.bend[cell] = bend / static_cast<float>(count);
      }
    }
  });
  cells_.extend_borders();
}

void ScreenShading::light(const ShadingView& shading, const LightProbe& probe,
                          const ShadowMap& shadow, const PictureView& view,
                          const Executor& executor, Picture& picture) {
  find_open(shading, view, executor, picture);
  const SrgbTables& srgb = SrgbTables::get();
  const bool avx2 = (cpu_features() & kCpuAvx2) != 0;
  const auto place = avx2 ? RowKernels::place_avx2 : RowKernels::place_portable;
  const auto light_row = avx2 ? RowKernels::light_avx2 : RowKernels::light_portable;
  const float near = view.eye.w, source = shading.reach.z;
  const glm::vec3 eye(view.eye);
  const auto light_pixels = [&](int x, int y, int count) {
    PixelRow row;
    Lanes depth = Lanes{} + 1.0f;
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(count); ++lane) {
      const std::size_t pixel = picture.index(x, y) + lane;
      if (picture.colors[pixel].a != kDrawn || !(picture.depths[pixel] > 0.0f)) continue;
      row.shown[lane] = -1;
      depth[lane] = picture.depths[pixel];
    }
    if (!any_lane(row.shown)) return;
    place(view, picture, cells_, x, y, depth, row);
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(count); ++lane) {
      if (row.shown[lane] == 0) continue;
      const glm::vec3 ray = lane_of(row.ray, lane), normal = lane_of(row.normal, lane);
      const glm::vec3 surface =
          source == 0.0f
              ? srgb.decode(picture.colors[picture.index(x, y) + lane])
              : false_color(shading, view, row.open[lane], row.bend[lane], near / depth[lane],
                            eye + lane_of(row.place, lane), ray, normal);
      const float shade = 0.4f + 0.6f * std::max(glm::dot(normal, glm::vec3(view.light)), 0.0f);
      const bool late = shading.reach.w == kLateLight;
      set_lane(row.surface, lane,
               late ? surface : surface * (shading.reach.w * shade + 1.0f - shading.reach.w));
    }
    // What shows how open a surface is does not show it as light, too.
    if (source == static_cast<float>(ColorSource::accessibility)) row.open = Lanes{} + 1.0f;
    if (shading.reach.w == kLateLight) light_row(shading, probe, shadow, eye, row);
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(count); ++lane)
      if (row.shown[lane] != 0)
        picture.colors[picture.index(x, y) + lane] =
            srgb.encode(lane_of(row.surface, lane), kDrawn);
  };
  for_each(executor, picture.grid.count(), [&](int tile) {
    if (!picture.busy[static_cast<std::size_t>(tile)]) return;
    const PixelRect pixels = picture.grid.pixels(tile);
    for (int y = pixels.min.y; y < pixels.max.y; ++y)
      for (int x = pixels.min.x; x < pixels.max.x; x += kLaneStep)
        light_pixels(x, y, std::min(kLaneStep, pixels.max.x - x));
  });
}

void ScreenShading::shade_floor(const ShadingView& shading, const ShadowMap& shadow,
                                const PictureView& view, const Executor& executor,
                                Picture& picture) {
  const float height = glm::dot(glm::vec3(view.eye), glm::vec3(shading.up)) - shading.up.w;
  if (!(height > 0.0f)) return;
  const auto shade_row =
      (cpu_features() & kCpuAvx2) != 0 ? RowKernels::floor_avx2 : RowKernels::floor_portable;
  for_each(executor, picture.grid.count(), [&](int tile) {
    const PixelRect pixels = picture.grid.pixels(tile);
    for (int y = pixels.min.y; y < pixels.max.y; ++y)
      shade_row(shading, shadow, view, height, {pixels.min.x, pixels.max.x}, y, picture);
  });
}

}  // namespace pointreel
