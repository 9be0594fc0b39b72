#include "client/render/software/effects.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "common/base/for_each.h"

namespace pointreel {
namespace {

/// exp(-x) for x >= 0, the same on every machine; wrong by less than 1e-6.
float exp_minus(float x) {
  if (!(x < 80.0f)) return 0.0f;
  const float halves = -x * 1.44269504f;  // exp(-x) = 2^halves
  const float whole = std::floor(halves);
  const float t = (halves - whole) * 0.69314718f;
  const float part =
      1.0f +
      t * (1.0f + t * (0.5f + t * (1.0f / 6.0f + t * (1.0f / 24.0f +
                                                      t * (1.0f / 120.0f + t * (1.0f / 720.0f))))));
  return part * std::bit_cast<float>((static_cast<std::int32_t>(whole) + 127) << 23);
}

/// log2(ratio), at least 0 and at most 0.1.
float short_log2(float ratio) {
  const float t = std::min(ratio - 1.0f, 0.0718f);
  if (!(t > 0.0f)) return 0.0f;
  const float log = t * (1.0f - t * (0.5f - t * (1.0f / 3.0f - t * (0.25f - 0.2f * t))));
  return std::min(1.44269504f * log, 0.1f);
}

float smoothstep(float from, float to, float v) {
  const float t = std::clamp((v - from) / (to - from), 0.0f, 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

}  // namespace

void light_eye_dome(float strength, const Executor& executor, Picture& picture) {
  constexpr int kAround[8][2] = {{1, 0},  {1, 1},   {0, 1},  {-1, 1},
                                 {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
  const glm::ivec2 last = picture.grid.size - 1;
  // A few pixels in large pictures, so that the fine grain of depths does not show.
  const int reach =
      std::max(1, static_cast<int>(static_cast<float>(picture.grid.size.y) / 720.0f + 0.5f));
  const SrgbTables& srgb = SrgbTables::get();
  for_each(executor, picture.grid.count(), [&](int tile) {
    if (!picture.busy[static_cast<std::size_t>(tile)]) return;
    const PixelRect pixels = picture.grid.pixels(tile);
    for (int y = pixels.min.y; y < pixels.max.y; ++y) {
      for (int x = pixels.min.x; x < pixels.max.x; ++x) {
        const std::size_t at = picture.index(x, y);
        const float own = picture.depths[at];
        glm::u8vec4& color = picture.colors[at];
        if (own == 0.0f || color.a != kDrawn) continue;
        float behind = 0.0f;
        for (const auto& step : kAround) {
          const int there_x = std::clamp(x + reach * step[0], 0, last.x),
                    there_y = std::clamp(y + reach * step[1], 0, last.y);
          // The logarithm of the ratio of the distances. Pixels that show nothing do not count.
          behind += short_log2(picture.depths[picture.index(there_x, there_y)] / own);
        }
        if (behind > 0.0f)
          color = srgb.encode(exp_minus(8.0f * strength * behind) * srgb.decode(color), kDrawn);
      }
    }
  });
}

void smooth_outlines(const PixelRect& region, const Executor& executor, Picture& picture) {
  if (region.empty()) return;
  constexpr int kReach = 2, kEdge = 2 * kReach + 1;
  struct Changed {
    std::size_t pixel;
    glm::u8vec4 color;
  };
  const TileGrid& grid = picture.grid;
  const SrgbTables& srgb = SrgbTables::get();
  std::vector<std::vector<Changed>> changed(static_cast<std::size_t>(grid.count()));
  const auto smooth_tile = [&](int tile) {
    const PixelRect pixels = grid.pixels(tile);
    const int x0 = std::max(pixels.min.x, region.min.x), x1 = std::min(pixels.max.x, region.max.x);
    const int y0 = std::max(pixels.min.y, region.min.y), y1 = std::min(pixels.max.y, region.max.y);
    if (x0 >= x1 || y0 >= y1) return;
    // Whether pixels are drawn, in the tile and around it. Beyond the region, the nearest counts.
    constexpr int kWidth = kTileWidth + 2 * kReach, kHeight = kTileHeight + 2 * kReach;
    std::array<std::array<std::uint8_t, kWidth>, kHeight> drawn, across;
    const int width = x1 - x0, height = y1 - y0;
    bool any = false, all = true;
    for (int y = -kReach; y < height + kReach; ++y) {
      const int row = std::clamp(y0 + y, region.min.y, region.max.y - 1);
      auto& to = drawn[static_cast<std::size_t>(y + kReach)];
      for (int x = -kReach; x < width + kReach; ++x) {
        const int column = std::clamp(x0 + x, region.min.x, region.max.x - 1);
        const bool is_drawn = picture.is_drawn(column, row);
        to[static_cast<std::size_t>(x + kReach)] = is_drawn;
        any = any || is_drawn;
        all = all && is_drawn;
      }
    }
    if (!any || all) return;
    // Sums of three neighbours in a row.
    for (int y = 0; y < height + 2 * kReach; ++y) {
      const auto& from = drawn[static_cast<std::size_t>(y)];
      auto& to = across[static_cast<std::size_t>(y)];
      for (std::size_t x = 1; x < static_cast<std::size_t>(width + 2 * kReach - 1); ++x)
        to[x] = static_cast<std::uint8_t>(from[x - 1] + from[x] + from[x + 1]);
    }
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        const auto row = static_cast<std::size_t>(y - y0 + kReach),
                   column = static_cast<std::size_t>(x - x0 + kReach);
        const int near = across[row - 1][column] + across[row][column] + across[row + 1][column];
        if (near == 0 || near == 9) continue;  // not beside an outline
        const bool own_drawn = drawn[row][column] != 0;
        glm::vec3 surface(0.0f), background(0.0f);
        int surfaces = 0, backgrounds = 0;
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            if (dx == 0 && dy == 0) continue;
            const glm::vec3 there = srgb.decode(
                picture.colors[picture.index(std::clamp(x + dx, region.min.x, region.max.x - 1),
                                             std::clamp(y + dy, region.min.y, region.max.y - 1))]);
            if (drawn[static_cast<std::size_t>(y + dy - y0 + kReach)]
                     [static_cast<std::size_t>(x + dx - x0 + kReach)] != 0) {
              surface += there;
              ++surfaces;
            } else {
              background += there;
              ++backgrounds;
            }
          }
        }
        if ((own_drawn ? backgrounds : surfaces) == 0) continue;
        int covered = 0;
        for (int dy = -kReach; dy <= kReach; ++dy)
          for (int dx = -kReach; dx <= kReach; ++dx)
            covered += drawn[static_cast<std::size_t>(y + dy - y0 + kReach)]
                            [static_cast<std::size_t>(x + dx - x0 + kReach)];
        // A straight outline at the distance d from the pixel's middle covers 1/2 + d / edge of a
        // square around it, and 1/2 + d of the pixel. Thin parts cover little of the square, and
        // must stay.
        float share = 0.5f + kEdge * (static_cast<float>(covered) / (kEdge * kEdge) - 0.5f);
        share = own_drawn ? std::clamp(share, 0.5f, 1.0f) : std::clamp(share, 0.0f, 0.5f);
        const std::size_t pixel = picture.index(x, y);
        const glm::u8vec4 own = picture.colors[pixel];
        surface = own_drawn ? srgb.decode(own) : surface / static_cast<float>(surfaces);
        background = own_drawn ? background / static_cast<float>(backgrounds) : srgb.decode(own);
        changed[static_cast<std::size_t>(tile)].push_back(
            {pixel, srgb.encode(glm::mix(background, surface, share), own.a)});
      }
    }
  };
  for_each(executor, grid.count(), smooth_tile);
  for (const auto& of_tile : changed)
    for (const Changed& one : of_tile) picture.colors[one.pixel] = one.color;
}

void draw_floor(const FloorGrid& grid, const Camera& camera, const PictureView& view,
                const glm::vec3& background, Picture& picture) {
  const FloorInk ink = floor_ink(background);
  const SrgbTables& srgb = SrgbTables::get();
  const auto reach = static_cast<float>(floor_reach(grid.bounds));
  const glm::ivec2 size = picture.grid.size;
  const glm::vec2 window(size);
  const float half_width = 0.5f * std::max(1.0f, window.y / 720.0f);
  const glm::mat4& m = view.to_clip;
  const auto row_of = [&m](int i) { return glm::vec3(m[0][i], m[1][i], m[2][i]); };
  const glm::vec3 right = row_of(0), above = row_of(1), forward = row_of(3), eye(view.eye);
  glm::vec3 up(0.0f);
  up[grid.up.axis()] = 1.0f;
  for (const FloorLine& line : floor_lines(grid, camera)) {
    const glm::vec4 a = m * glm::vec4(line.from, 1.0f), b = m * glm::vec4(line.to, 1.0f);
    if (!(a.w > 0.0f) || !(b.w > 0.0f)) continue;
    const glm::vec2 from = 0.5f * window * (glm::vec2(a) / a.w + 1.0f),
                    to = 0.5f * window * (glm::vec2(b) / b.w + 1.0f);
    const glm::vec2 along = to - from;
    const float length = glm::length(along);
    if (!(length > 1e-6f) || !(length < 1e9f)) continue;
    const glm::vec2 direction = along / length;
    const glm::vec3 across_line = glm::cross(up, glm::normalize(line.to - line.from));
    const glm::vec3 along_line = glm::normalize(line.to - line.from);
    // One pixel after another along the longer side of the line, and the few across it.
    const int major = std::abs(direction.x) >= std::abs(direction.y) ? 0 : 1, minor = 1 - major;
    const float thickness = (half_width + 0.5f) / std::abs(direction[major]);
    const int first =
                  std::max(0, static_cast<int>(std::ceil(std::clamp(
                                  std::min(from[major], to[major]) - 0.5f, -1.0f, window[major])))),
              last = std::min(size[major] - 1,
                              static_cast<int>(std::floor(std::clamp(
                                  std::max(from[major], to[major]) - 0.5f, -1.0f, window[major]))));
    for (int i = first; i <= last; ++i) {
      const float step = static_cast<float>(i) + 0.5f - from[major];
      const float middle = from[minor] + step * direction[minor] / direction[major];
      if (!(middle > -thickness - 1.0f && middle < window[minor] + thickness + 1.0f)) continue;
      const int low = std::max(0, static_cast<int>(std::ceil(middle - thickness - 0.5f))),
                high = std::min(size[minor] - 1,
                                static_cast<int>(std::floor(middle + thickness - 0.5f)));
      for (int j = low; j <= high; ++j) {
        glm::vec2 pixel;
        pixel[major] = static_cast<float>(i) + 0.5f;
        pixel[minor] = static_cast<float>(j) + 0.5f;
        const glm::vec2 offset = pixel - from;
        const float side = offset.x * direction.y - offset.y * direction.x;
        const float t = std::clamp(glm::dot(offset, direction) / length, 0.0f, 1.0f);
        // The place on the line, with perspective.
        const float inverse_w = glm::mix(1.0f / a.w, 1.0f / b.w, t);
        const glm::vec3 place = glm::mix(line.from / a.w, line.to / b.w, t) / inverse_w;
        // The distance in pixels to the next line of the same strength (floor.frag.glsl).
        const float w = 1.0f / inverse_w;
        const glm::vec3 from_eye = place - eye;
        const glm::vec3 x = 0.5f * window.x / w * (right - glm::dot(right, from_eye) / w * forward);
        const glm::vec3 y = 0.5f * window.y / w * (above - glm::dot(above, from_eye) / w * forward);
        const glm::vec2 unit(glm::dot(x, along_line), glm::dot(y, along_line));
        const glm::vec2 next =
            line.step * glm::vec2(glm::dot(x, across_line), glm::dot(y, across_line));
        const float to_next = std::abs(unit.x * next.y - unit.y * next.x) /
                              std::sqrt(std::max(glm::dot(unit, unit), 1e-12f));
        const float coverage = std::clamp(half_width + 0.5f - std::abs(side), 0.0f, 1.0f);
        const float rim = 1.0f - smoothstep(0.35f, 1.0f, glm::length(place) / reach);
        const float crowding = smoothstep(4.0f * half_width, 20.0f * half_width, to_next);
        const float opacity = ink.opacity * line.strength * coverage * rim * crowding;
        if (!(opacity > 0.0f)) continue;
        glm::u8vec4& color = picture.colors[picture.index(major == 0 ? i : j, major == 0 ? j : i)];
        color = srgb.encode(glm::mix(srgb.decode(color), glm::vec3(ink.light), opacity), color.a);
      }
    }
  }
}

}  // namespace pointreel
