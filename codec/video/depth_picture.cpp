#include "codec/video/depth_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "common/base/for_each.h"

namespace pointreel {
namespace {

/// How far the depth of a neighbour on the same surface may be, in pixels.
constexpr float kSameSurface = 2.0f;
constexpr int kLeastSupport = 3;

std::size_t at(const VideoGroup& group, int x, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(group.width) +
         static_cast<std::size_t>(x);
}

bool has_point(float depth) { return depth > 0.5f * DepthPicture::kNoPoint; }

/// The depth in a patch, with a rim of pixels without points around it.
class PatchDepth {
 public:
  PatchDepth(const VideoGroup& group, const Patch& patch, const std::vector<float>& depth)
      : row_(patch.width + 2),
        values_(static_cast<std::size_t>(row_) * static_cast<std::size_t>(patch.height + 2),
                DepthPicture::kNoPoint) {
    for (int y = 0; y < patch.height; ++y) {
      const auto from =
          depth.begin() + static_cast<std::ptrdiff_t>(at(group, patch.atlas_x, patch.atlas_y + y));
      std::copy(from, from + patch.width, values_.begin() + (y + 1) * row_ + 1);
    }
  }

  const float* pixel(int x, int y) const {
    return &values_[static_cast<std::size_t>((y + 1) * row_ + x + 1)];
  }
  int row() const { return row_; }

 private:
  int row_;
  std::vector<float> values_;
};

bool is_supported(const float* pixel, int row) {
  int support = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      support += std::abs(pixel[dy * row + dx] - *pixel) <= kSameSurface ? 1 : 0;
  return support > kLeastSupport;  // the pixel itself is one
}

/// How much the depth rises from a pixel to the next one to the right and down: the plane that fits
/// the pixel and its neighbours on the same surface best.
glm::vec2 slopes_at(const float* pixel, int row) {
  glm::vec2 rise(0.0f), run(0.0f);
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const float step = pixel[dy * row + dx] - *pixel;
      if (!(std::abs(step) <= kSameSurface)) continue;
      const glm::vec2 way(dx, dy);
      rise += step * way;
      run += way * way;
    }
  }
  return rise / glm::max(run, 1.0f);
}

std::uint16_t sixteen_bits(float value) {
  return static_cast<std::uint16_t>(257 * static_cast<int>(std::clamp(value, 0.0f, 255.0f) + 0.5f));
}

}  // namespace

glm::vec3 rgb_of(const glm::vec3& c) {
  const float b = c.y - 128.0f, r = c.z - 128.0f;
  const float red = c.x + 1.5748f * r, blue = c.x + 1.8556f * b;
  return {red, (c.x - 0.2126f * red - 0.0722f * blue) / 0.7152f, blue};
}

glm::vec3 ycbcr_of(const glm::vec3& rgb) {
  const float y = 0.2126f * rgb.x + 0.7152f * rgb.y + 0.0722f * rgb.z;
  return {y, (rgb.z - y) / 1.8556f + 128.0f, (rgb.x - y) / 1.5748f + 128.0f};
}

DepthPicture read_depth(const VideoGroup& group, const std::vector<std::uint8_t>& mask,
                        const PlaneView<std::uint16_t>& picture, const Executor& executor) {
  DepthPicture read{std::vector<float>(group.pixels(), DepthPicture::kNoPoint)};
  for_each(executor, static_cast<int>(group.patches.size()), [&](int i) {
    const Patch& patch = group.patches[static_cast<std::size_t>(i)];
    const DepthSteps& steps = group.depth[static_cast<std::size_t>(patch.view)];
    const float pixels = 1.0f / steps.steps;
    for (int y = patch.atlas_y; y < patch.atlas_y + patch.height; ++y) {
      for (int x = patch.atlas_x; x < patch.atlas_x + patch.width; ++x) {
        if (mask[at(group, x, y)] != 0)
          read.depth[at(group, x, y)] = steps.begin + pixels * static_cast<float>(picture.at(x, y));
      }
    }
    const PatchDepth around(group, patch, read.depth);
    for (int y = 0; y < patch.height; ++y) {
      for (int x = 0; x < patch.width; ++x) {
        float& depth = read.depth[at(group, patch.atlas_x + x, patch.atlas_y + y)];
        if (has_point(depth) && !is_supported(around.pixel(x, y), around.row()))
          depth = DepthPicture::kNoPoint;
      }
    }
  });
  return read;
}

PointCloud points_of(const VideoGroup& group, const DepthPicture& depth, const Av1Picture* colors,
                     bool normals, const Executor& executor) {
  const std::size_t patches = group.patches.size();
  std::vector<std::size_t> begins(patches + 1, 0);
  for (std::size_t i = 0; i < patches; ++i) {
    const Patch& patch = group.patches[i];
    std::size_t count = 0;
    for (int y = 0; y < patch.height; ++y) {
      const float* const row = &depth.depth[at(group, patch.atlas_x, patch.atlas_y + y)];
      count += static_cast<std::size_t>(std::count_if(row, row + patch.width, has_point));
    }
    begins[i + 1] = begins[i] + count;
  }
  PointCloud cloud;
  cloud.origin = group.origin;
  cloud.positions.resize(begins.back());
  if (normals) cloud.normals.resize(begins.back());
  if (colors != nullptr) cloud.colors.resize(begins.back());
  const auto pitch = static_cast<float>(group.pitch);
  for_each(executor, static_cast<int>(patches), [&](int i) {
    const Patch& patch = group.patches[static_cast<std::size_t>(i)];
    const ViewAxes& axes = kViewAxes[static_cast<std::size_t>(patch.view)];
    const PatchDepth around(group, patch, depth.depth);
    std::size_t next = begins[static_cast<std::size_t>(i)];
    for (int y = 0; y < patch.height; ++y) {
      for (int x = 0; x < patch.width; ++x) {
        const float* const pixel = around.pixel(x, y);
        if (!has_point(*pixel)) continue;
        cloud.positions[next] = pitch * place_of(patch, x, y, *pixel);
        if (normals) {
          const glm::vec2 slopes = axes.facing * slopes_at(pixel, around.row());
          glm::vec3 normal;
          normal[axes.depth] = axes.facing;
          normal[axes.u] = -slopes.x;
          normal[axes.v] = -slopes.y;
          cloud.normals[next] = glm::normalize(normal);
        }
        if (colors != nullptr) {
          const int px = patch.atlas_x + x, py = patch.atlas_y + y;
          const glm::vec3 rgb = rgb_of({colors->luma.at(px, py), colors->cb.at(px / 2, py / 2),
                                        colors->cr.at(px / 2, py / 2)});
          cloud.colors[next] = {sixteen_bits(rgb.x), sixteen_bits(rgb.y), sixteen_bits(rgb.z)};
        }
        ++next;
      }
    }
  });
  return cloud;
}

}  // namespace pointreel
