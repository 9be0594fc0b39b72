#include "client/render/software/screen_shading.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/for_each.h"

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

/// The normal with which a pixel is shaded. Where the surfaces that it shows do not agree, or seem
/// to face away, it is turned towards the eye.
glm::vec3 shading_normal(const glm::vec3& mean, const glm::vec3& to_eye) {
  const float length = std::sqrt(glm::dot(mean, mean));
  const glm::vec3 n = unit(mean + std::max(1.0f - length, 0.0f) * to_eye);
  const float facing = glm::dot(n, to_eye);
  return facing >= kLeastFacing ? n : unit(n + (kLeastFacing - facing) * to_eye);
}

glm::vec3 diffuse_light(const ShadingView& s, const glm::vec3& n) {
  const auto& c = s.diffuse;
  return glm::max(glm::vec3(c[0] + c[1] * n.y + c[2] * n.z + c[3] * n.x + c[4] * (n.x * n.y) +
                            c[5] * (n.y * n.z) + c[6] * (3.0f * n.z * n.z - 1.0f) +
                            c[7] * (n.x * n.z) + c[8] * (n.x * n.x - n.y * n.y)),
                  0.0f);
}

/// LightProbe::glossy in a direction.
glm::vec3 glossy_light(const LightProbe& probe, const glm::vec3& d) {
  constexpr int kEdge = LightProbe::kGlossyEdge, kStride = kEdge + 2;
  const float scale = 1.0f / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
  glm::vec2 p = scale * glm::vec2(d.x, d.z);
  if (d.y < 0.0f)
    p = glm::vec2(p.x < 0.0f ? -1.0f : 1.0f, p.y < 0.0f ? -1.0f : 1.0f) *
        (1.0f - glm::vec2(std::abs(p.y), std::abs(p.x)));
  // In texels, beginning with the middle of the one around the map.
  const glm::vec2 at = (0.5f * p + 0.5f) * static_cast<float>(kEdge) + 0.5f;
  const int x = std::clamp(static_cast<int>(at.x), 0, kEdge),
            y = std::clamp(static_cast<int>(at.y), 0, kEdge);
  const glm::vec2 share = at - glm::vec2(x, y);
  const glm::vec3 *low = &probe.glossy[static_cast<std::size_t>(y * kStride + x)],
                  *high = low + kStride;
  return glm::mix(glm::mix(low[0], low[1], share.x), glm::mix(high[0], high[1], share.x), share.y);
}

/// Between colours that are at the same distance from each other; linear light.
template <std::size_t kCount>
glm::vec3 ramp(const glm::vec3 (&colors)[kCount], float share) {
  const float at = std::clamp(share, 0.0f, 1.0f) * static_cast<float>(kCount - 1);
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

/// Light up to kLinear stays, and all light above it fits below 1.
float tone(float light) {
  constexpr float kLinear = 0.6f;
  if (!(light > kLinear)) return light;
  const float more = (light - kLinear) / (1.0f - kLinear);
  return kLinear + (1.0f - kLinear) * more / (1.0f + more);
}

}  // namespace

void ScreenShading::find_open(const ShadingView& shading, const PictureView& view,
                              const Executor& executor, const Picture& picture) {
  const glm::ivec2 size = picture.grid.size;
  cells_size_ = (size + 1) / 2;
  cells_.resize(static_cast<std::size_t>(cells_size_.x) * static_cast<std::size_t>(cells_size_.y));
  std::array<std::array<glm::vec2, kTaps>, 4> taps;
  for (int turn = 0; turn < 4; ++turn)
    for (int i = 0; i < kTaps; ++i)
      taps[static_cast<std::size_t>(turn)][static_cast<std::size_t>(i)] = tap(i, turn);
  const bool bends = shading.reach.z == static_cast<float>(ColorSource::curvature);
  const float near = view.eye.w, reach = shading.reach.x, inverse_reach2 = 1.0f / (reach * reach);
  for_each(executor, picture.grid.count(), [&](int tile) {
    const PixelRect pixels = picture.grid.pixels(tile);
    const bool busy = picture.busy[static_cast<std::size_t>(tile)] != 0;
    for (int y = pixels.min.y; y < pixels.max.y; y += 2) {
      for (int x = pixels.min.x; x < pixels.max.x; x += 2) {
        Cell& cell =
            cells_[static_cast<std::size_t>(y / 2) * static_cast<std::size_t>(cells_size_.x) +
                   static_cast<std::size_t>(x / 2)];
        cell = {0.0f, 1.0f, 0.0f};
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
        float taken = 0.0f;
        const int turn = (x / 2 & 1) + 2 * (y / 2 & 1);
        for (const glm::vec2& step : taps[static_cast<std::size_t>(turn)]) {
          const int there_x = at.x + static_cast<int>(std::floor(most * step.x + 0.5f)),
                    there_y = at.y + static_cast<int>(std::floor(most * step.y + 0.5f));
          if (there_x < 0 || there_y < 0 || there_x >= size.x || there_y >= size.y) continue;
          const float there = picture.depths[picture.index(there_x, there_y)];
          if (there == 0.0f) continue;
          const glm::vec3 away = near / there * pixel_ray(view, there_x, there_y) - place;
          const float distance2 = glm::dot(away, away);
          const float above = glm::dot(away, normal) - tolerance;
          const float near_share = 1.0f - distance2 * inverse_reach2;
          if (above > 0.0f && near_share > 0.0f)
            taken += near_share * above / std::sqrt(distance2 + 1e-30f);
        }
        const float open = std::max(0.0f, 1.0f - kOcclusion / kTaps * taken);
        cell = {depth, open, 0.0f};
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
        if (count > 0) cell.bend = bend / static_cast<float>(count);
      }
    }
  });
}

ScreenShading::Cell ScreenShading::cell_at(int x, int y, float depth) const {
  // The cell of the pixel and its neighbours on the side of the pixel, unless they are of another
  // surface.
  const int step_x = (x & 1) != 0 ? 1 : -1, step_y = (y & 1) != 0 ? 1 : -1;
  Cell sum{depth, 0.0f, 0.0f};
  float weights = 0.0f;
  for (int i = 0; i < 4; ++i) {
    const int cx = std::clamp(x / 2 + (i & 1) * step_x, 0, cells_size_.x - 1),
              cy = std::clamp(y / 2 + (i >> 1) * step_y, 0, cells_size_.y - 1);
    const Cell& cell =
        cells_[static_cast<std::size_t>(cy) * static_cast<std::size_t>(cells_size_.x) +
               static_cast<std::size_t>(cx)];
    const float apart = std::abs(cell.depth - depth);
    const float weight = apart < 0.02f * depth ? 1.0f : 1e-3f;
    sum.open += weight * cell.open;
    sum.bend += weight * cell.bend;
    weights += weight;
  }
  sum.open /= weights;
  sum.bend /= weights;
  return sum;
}

void ScreenShading::light(const ShadingView& shading, const LightProbe& probe,
                          const ShadowMap& shadow, const PictureView& view,
                          const Executor& executor, Picture& picture) {
  find_open(shading, view, executor, picture);
  const SrgbTables& srgb = SrgbTables::get();
  const float near = view.eye.w, source = shading.reach.z;
  const float roughness = shading.key.w, alpha2 = roughness * roughness * roughness * roughness;
  const glm::vec3 eye(view.eye), key_direction(shading.key_direction), key(shading.key);
  const glm::mat3 to_environment(shading.to_environment);
  for_each(executor, picture.grid.count(), [&](int tile) {
    if (!picture.busy[static_cast<std::size_t>(tile)]) return;
    const PixelRect pixels = picture.grid.pixels(tile);
    for (int y = pixels.min.y; y < pixels.max.y; ++y) {
      for (int x = pixels.min.x; x < pixels.max.x; ++x) {
        const std::size_t pixel = picture.index(x, y);
        const float depth = picture.depths[pixel];
        glm::u8vec4& color = picture.colors[pixel];
        if (color.a != kDrawn || !(depth > 0.0f)) continue;
        const glm::vec3 ray = pixel_ray(view, x, y);
        const glm::vec3 place = near / depth * ray;  // relative to the eye
        const glm::vec3 to_eye = -unit(ray),
                        normal = shading_normal(picture.normals[pixel], to_eye);
        const Cell cell = cell_at(x, y, depth);
        const glm::vec3 surface = source == 0.0f
                                      ? srgb.decode(color)
                                      : false_color(shading, view, cell.open, cell.bend,
                                                    near / depth, eye + place, ray, normal);
        if (shading.reach.w != kLateLight) {
          const float shade = 0.4f + 0.6f * std::max(glm::dot(normal, glm::vec3(view.light)), 0.0f);
          color = srgb.encode(surface * (shading.reach.w * shade + 1.0f - shading.reach.w), kDrawn);
          continue;
        }
        const float open =
            source == static_cast<float>(ColorSource::accessibility) ? 1.0f : cell.open;
        const float facing = std::max(glm::dot(normal, to_eye), 1e-3f);
        const float lit = glm::dot(normal, key_direction);

        glm::vec3 diffuse = open * diffuse_light(shading, to_environment * normal);
        // The environment's share of highlights (B. Karis, "Physically Based Shading on Mobile",
        // 2014).
        const glm::vec2 part = environment_share(roughness, facing);
        const glm::vec3 mirrored = 2.0f * glm::dot(normal, to_eye) * normal - to_eye;
        glm::vec3 highlight = open * (kReflectance * part.x + part.y) *
                              glossy_light(probe, to_environment * mirrored);
        if (lit > 0.0f && key != glm::vec3(0.0f)) {
          const glm::vec3 there = glm::vec3(shading.to_shadow * glm::vec4(eye + place, 1.0f));
          const float reaches = lit * shadow.light_at(there, shading.key_direction.w);
          if (reaches > 0.0f) {
            diffuse += reaches * key;
            const glm::vec3 half = unit(to_eye + key_direction);
            highlight += reaches *
                         highlight_of(alpha2, std::max(glm::dot(normal, half), 0.0f), facing, lit,
                                      glm::dot(to_eye, half)) *
                         key;
          }
        }
        const glm::vec3 light = surface * diffuse + highlight;
        color = srgb.encode({tone(light.x), tone(light.y), tone(light.z)}, kDrawn);
      }
    }
  });
}

void ScreenShading::shade_floor(const ShadingView& shading, const ShadowMap& shadow,
                                const PictureView& view, const Executor& executor,
                                Picture& picture) {
  const SrgbTables& srgb = SrgbTables::get();
  const glm::vec3 eye(view.eye), up(shading.up);
  const float height = glm::dot(eye, up) - shading.up.w;
  if (!(height > 0.0f)) return;
  for_each(executor, picture.grid.count(), [&](int tile) {
    const PixelRect pixels = picture.grid.pixels(tile);
    for (int y = pixels.min.y; y < pixels.max.y; ++y)
      for (int x = pixels.min.x; x < pixels.max.x; ++x) {
        const glm::vec3 ray = pixel_ray(view, x, y);
        const float down = -glm::dot(ray, up);
        if (!(down > 0.0f)) continue;
        const glm::vec3 there =
            glm::vec3(shading.to_shadow * glm::vec4(eye + height / down * ray, 1.0f));
        const float lit = shadow.light_at(there, shading.key_direction.w);
        if (lit == 1.0f) continue;
        glm::u8vec4& color = picture.colors[picture.index(x, y)];
        color = srgb.encode((1.0f - kFloorShadow * (1.0f - lit)) * srgb.decode(color), color.a);
      }
  });
}

}  // namespace pointreel
