#include "codec/video/picture_points.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <vector>

#include "common/base/for_each.h"

namespace pointreel {
namespace {

/// Surfaces that are seen from the side more than this get no larger radii: their slopes are
/// those of edges.
constexpr float kLeastFacing = 0.25f;

/// The sign bits of four numbers of 16 bits.
constexpr std::uint64_t kSigns = 0x8000800080008000u;

/// 1 / sqrt(x) with a relative error of 5e-6, for x from 1: a guess from the bits of the number and
/// two steps of Newton's method.
float inverse_root(float x) {
  float y = std::bit_cast<float>(0x5f375a86u - (std::bit_cast<std::uint32_t>(x) >> 1));
  const float half = 0.5f * x;
  y *= 1.5f - half * y * y;
  return y * (1.5f - half * y * y);
}

/// Parts of the normals of a row along the axes of a view.
struct NormalRow {
  std::vector<float> u, v, depth;

  explicit NormalRow(std::size_t size) : u(size), v(size), depth(size) {}

  /// Of the planes that fit each pixel and its neighbours on the same surface best. `up`, `middle`
  /// and `down` are the depths of three rows, `limit` is how far a neighbour may be, both in values
  /// of so many `pixels`. Loops without branches, which compilers vectorise.
  void fit(const std::int16_t* up, const std::int16_t* middle, const std::int16_t* down,
           std::int16_t limit, float pixels, float facing, int count) {
    float* const us = u.data();
    float* const vs = v.data();
    float* const depths = depth.data();
    for (int x = 0; x < count; ++x) {
      const std::int16_t center = middle[x];
      std::int16_t rise_u = 0, rise_v = 0, run_u = 0, run_v = 0;
      const auto add = [&](const std::int16_t* line, int dx, int dy) {
        const auto step = static_cast<std::int16_t>(line[x + dx] - center);
        const auto size = static_cast<std::int16_t>(step < 0 ? -step : step);
        const auto near = static_cast<std::int16_t>(size <= limit ? -1 : 0);
        const auto rise = static_cast<std::int16_t>(step & near);
        if (dx != 0) {
          rise_u = static_cast<std::int16_t>(dx > 0 ? rise_u + rise : rise_u - rise);
          run_u = static_cast<std::int16_t>(run_u - near);
        }
        if (dy != 0) {
          rise_v = static_cast<std::int16_t>(dy > 0 ? rise_v + rise : rise_v - rise);
          run_v = static_cast<std::int16_t>(run_v - near);
        }
      };
      add(up, -1, -1);
      add(up, 0, -1);
      add(up, 1, -1);
      add(middle, -1, 0);
      add(middle, 1, 0);
      add(down, -1, 1);
      add(down, 0, 1);
      add(down, 1, 1);
      const auto most = [](std::int16_t run) { return run > 1 ? run : std::int16_t{1}; };
      const float slope_u =
          -facing * pixels * static_cast<float>(rise_u) / static_cast<float>(most(run_u));
      const float slope_v =
          -facing * pixels * static_cast<float>(rise_v) / static_cast<float>(most(run_v));
      const float scale = inverse_root(1.0f + slope_u * slope_u + slope_v * slope_v);
      us[x] = slope_u * scale;
      vs[x] = slope_v * scale;
      depths[x] = facing * scale;
    }
  }
};

/// 64 times what chroma adds to red, green and blue.
struct ChromaTable {
  std::array<std::int16_t, 256> red_of_cr, green_of_cr, green_of_cb, blue_of_cb;
};
constexpr ChromaTable make_chroma() {
  ChromaTable table{};
  for (int i = 0; i < 256; ++i) {
    const auto part = [&](double factor) {
      const double value = 64.0 * factor * (i - 128);
      return static_cast<std::int16_t>(value < 0.0 ? value - 0.5 : value + 0.5);
    };
    const auto at = static_cast<std::size_t>(i);
    table.red_of_cr[at] = part(1.5748);
    table.green_of_cr[at] = part(-0.2126 * 1.5748 / 0.7152);
    table.green_of_cb[at] = part(-0.0722 * 1.8556 / 0.7152);
    table.blue_of_cb[at] = part(1.8556);
  }
  return table;
}
constexpr ChromaTable kChroma = make_chroma();

/// The colours of a row.
struct ColorRow {
  std::array<std::vector<std::int16_t>, 3> chroma;
  std::array<std::vector<std::uint16_t>, 3> rgb;

  explicit ColorRow(std::size_t size) {
    for (auto& part : chroma) part.resize(size);
    for (auto& part : rgb) part.resize(size);
  }

  void convert(const std::uint8_t* luma, const std::uint8_t* cb, const std::uint8_t* cr,
               int count) {
    for (int x = 0; x < count / 2; ++x) {
      const auto put = [&](std::size_t c, int value) {
        chroma[c][static_cast<std::size_t>(2 * x)] =
            chroma[c][static_cast<std::size_t>(2 * x + 1)] = static_cast<std::int16_t>(value);
      };
      put(0, kChroma.red_of_cr[cr[x]]);
      put(1, kChroma.green_of_cr[cr[x]] + kChroma.green_of_cb[cb[x]]);
      put(2, kChroma.blue_of_cb[cb[x]]);
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const std::int16_t* const add = chroma[c].data();
      std::uint16_t* const out = rgb[c].data();
      for (int x = 0; x < count; ++x) {
        const auto sum = static_cast<std::int16_t>(64 * luma[x] + 32 + add[x]);
        const auto value = static_cast<std::int16_t>(sum >> 6);
        const auto least = static_cast<std::int16_t>(value < 0 ? 0 : value);
        out[x] = static_cast<std::uint16_t>(257 * (least > 255 ? 255 : least));
      }
    }
  }
};

/// Four depths at once: the sign bits of those without a point.
std::uint64_t missing_of_four(const std::int16_t* depths) {
  std::array<std::int16_t, 4> four;
  std::memcpy(four.data(), depths, sizeof(four));
  return std::bit_cast<std::uint64_t>(four) & kSigns;
}

bool any_point(const std::int16_t* depths) {
  std::uint64_t missing = kSigns;
  for (int x = 0; x < kPatchGrain; x += 4) missing &= missing_of_four(depths + x);
  return missing != kSigns;
}

/// The numbers of the depths that are points, with room for one more; returns how many.
std::size_t choose_points(const std::int16_t* depths, int count, std::uint16_t* chosen) {
  std::size_t next = 0;
  for (int x = 0; x < count; x += 4) {
    const std::uint64_t missing = missing_of_four(depths + x);
    if (missing == kSigns) continue;
    for (int i = x; i < x + 4; ++i) {
      chosen[next] = static_cast<std::uint16_t>(i);
      next += depths[i] >= 0 ? 1 : 0;
    }
  }
  return next;
}

/// Makes the points of a patch.
class PatchPoints {
 public:
  PatchPoints(const VideoGroup& group, const Patch& patch, const PixelDepths& depths,
              const Av1Picture* colors, const PointParts& parts)
      : group_(group),
        patch_(patch),
        axes_(kViewAxes[static_cast<std::size_t>(patch.view)]),
        steps_(group.depth[static_cast<std::size_t>(patch.view)]),
        limit_(static_cast<std::int16_t>(same_surface(steps_))),
        depths_(depths),
        colors_(colors),
        parts_(parts),
        chosen_(static_cast<std::size_t>(patch.width) + 1),
        normal_row_(static_cast<std::size_t>(patch.width)),
        color_row_(static_cast<std::size_t>(patch.width)) {
    for (std::vector<std::int16_t>& row : rows_)
      row.assign(static_cast<std::size_t>(patch.width) + 2, PixelDepths::kNoPoint);
  }

  void put(PointCloud& cloud, std::size_t next) {
    if (parts_.normals) load(0);
    for (int y = 0; y < patch_.height; ++y) {
      const std::int16_t* depths = depths_of(y);
      if (parts_.normals) load(y + 1);
      int end = 0;
      for (int begin = 0; begin < patch_.width; begin = end + kPatchGrain) {
        end = begin;
        while (end < patch_.width && any_point(depths + end)) end += kPatchGrain;
        if (end > begin) next = put(begin, end, y, cloud, next);
      }
    }
  }

 private:
  const std::int16_t* depths_of(int y) const {
    return &depths_.values[group_.pixel(patch_.atlas_x, patch_.atlas_y + y)];
  }
  /// With a pixel before and one behind it.
  std::int16_t* row(int y) { return rows_[static_cast<std::size_t>(y + 3) % 3].data() + 1; }
  void load(int y) {
    if (y < patch_.height) {
      std::copy_n(depths_of(y), patch_.width, row(y));
    } else {
      std::fill_n(row(y), patch_.width, PixelDepths::kNoPoint);
    }
  }

  /// Puts the points of a part of a row.
  std::size_t put(int begin, int end, int y, PointCloud& cloud, std::size_t next) {
    const auto pitch = static_cast<float>(group_.pitch);
    const float pixels = 1.0f / steps_.steps;
    const std::int16_t* const depths = depths_of(y) + begin;
    const std::size_t count = choose_points(depths, end - begin, chosen_.data());
    const float left = static_cast<float>(patch_.x + begin) + 0.5f;
    const float down = pitch * (static_cast<float>(patch_.y + y) + 0.5f);
    float* position = &cloud.positions[next].x;
    for (std::size_t k = 0; k < count; ++k, position += 3) {
      const std::uint16_t x = chosen_[k];
      position[axes_.u] = pitch * (left + static_cast<float>(x));
      position[axes_.v] = down;
      position[axes_.depth] = pitch * (steps_.begin + pixels * static_cast<float>(depths[x]));
    }
    if (parts_.normals) {
      normal_row_.fit(row(y - 1) + begin, row(y) + begin, row(y + 1) + begin, limit_, pixels,
                      axes_.facing, end - begin);
      std::array<const float*, 3> along;
      along[static_cast<std::size_t>(axes_.u)] = normal_row_.u.data();
      along[static_cast<std::size_t>(axes_.v)] = normal_row_.v.data();
      along[static_cast<std::size_t>(axes_.depth)] = normal_row_.depth.data();
      glm::vec3* const normals = &cloud.normals[next];
      for (std::size_t k = 0; k < count; ++k)
        normals[k] = {along[0][chosen_[k]], along[1][chosen_[k]], along[2][chosen_[k]]};
      if (parts_.radii) {
        float* const radii = &cloud.radii[next];
        for (std::size_t k = 0; k < count; ++k)
          radii[k] =
              pitch / std::sqrt(std::max(kLeastFacing, std::abs(normal_row_.depth[chosen_[k]])));
      }
    }
    if (colors_ != nullptr) {
      const int px = patch_.atlas_x + begin, py = patch_.atlas_y + y;
      color_row_.convert(colors_->luma.from(px, py), colors_->cb.from(px / 2, py / 2),
                         colors_->cr.from(px / 2, py / 2), end - begin);
      const auto& rgb = color_row_.rgb;
      glm::u16vec3* const colors = &cloud.colors[next];
      for (std::size_t k = 0; k < count; ++k)
        colors[k] = {rgb[0][chosen_[k]], rgb[1][chosen_[k]], rgb[2][chosen_[k]]};
    }
    return next + count;
  }

  const VideoGroup& group_;
  const Patch& patch_;
  const ViewAxes& axes_;
  const DepthSteps& steps_;
  const std::int16_t limit_;
  const PixelDepths& depths_;
  const Av1Picture* const colors_;
  const PointParts parts_;
  std::vector<std::uint16_t> chosen_;  ///< the pixels of a part of a row that have points
  NormalRow normal_row_;
  ColorRow color_row_;
  std::array<std::vector<std::int16_t>, 3> rows_;
};

}  // namespace

glm::vec3 ycbcr_of(const glm::vec3& rgb) {
  const float y = 0.2126f * rgb.x + 0.7152f * rgb.y + 0.0722f * rgb.z;
  return {y, (rgb.z - y) / 1.8556f + 128.0f, (rgb.x - y) / 1.5748f + 128.0f};
}

PointCloud points_of(const VideoGroup& group, const PixelDepths& depths, const Av1Picture* colors,
                     const PointParts& parts, std::size_t spare, const Executor& executor) {
  const std::size_t patches = group.patches.size();
  std::vector<std::size_t> begins(patches + 1, 0);
  std::partial_sum(depths.points.begin(), depths.points.end(), begins.begin() + 1);
  PointCloud cloud;
  cloud.origin = group.origin;
  const auto make = [&](auto& values) {
    values.reserve(begins.back() + spare);
    values.resize(begins.back());
  };
  make(cloud.positions);
  if (parts.normals) make(cloud.normals);
  if (parts.radii) make(cloud.radii);
  if (colors != nullptr) make(cloud.colors);
  for_each(executor, static_cast<int>(patches), [&](int i) {
    const auto p = static_cast<std::size_t>(i);
    PatchPoints(group, group.patches[p], depths, colors, parts).put(cloud, begins[p]);
  });
  return cloud;
}

}  // namespace pointreel
