#include "codec/files/depth_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <vector>

namespace pointreel {
namespace {

/// Of the window of a normal.
constexpr int kReach = 2;

/// 1 / depth of each pixel, in which planes are linear; 0 where nothing was measured.
using InverseDepth = std::vector<float>;

InverseDepth inverse_depth(const DepthPicture& depth) {
  InverseDepth inverse(depth.values.size());
  for (std::size_t i = 0; i < inverse.size(); ++i) {
    const std::uint16_t value = depth.values[i];
    const float reciprocal = 1.0f / static_cast<float>(value);
    inverse[i] = value == kNoDepth || value == kTooFar ? 0.0f : reciprocal;
  }
  return inverse;
}

/// Whether a pixel flies between the two on both sides of it.
bool flies(float before, float here, float after) {
  const float limit = kDepthJump * here;
  return std::abs(before - here) > limit && std::abs(after - here) > limit && before + after > 0.0f;
}

/// The same, without the pixels that fly.
InverseDepth without_flying(const InverseDepth& all, std::size_t width, std::size_t height) {
  InverseDepth kept = all;
  for (std::size_t y = 0; y < height; ++y) {
    const float* const row = all.data() + y * width;
    float* const to = kept.data() + y * width;
    const bool inner = y > 0 && y + 1 < height;
    for (std::size_t x = 0; x < width; ++x) {
      const bool in_row = x > 0 && x + 1 < width && flies(row[x - 1], row[x], row[x + 1]);
      const bool in_column = inner && flies(all[(y - 1) * width + x], row[x], row[x + width]);
      if (in_row || in_column) to[x] = 0.0f;
    }
  }
  return kept;
}

/// How the inverse depth changes about each pixel of a row, by least squares.
class RowPlanes {
 public:
  explicit RowPlanes(std::size_t width) {
    for (std::vector<float>* sum : {&n_, &u_, &v_, &uu_, &uv_, &vv_, &w_, &uw_, &vw_})
      sum->resize(width);
  }

  void fit(const InverseDepth& inverse, std::size_t width, std::size_t height, std::size_t y) {
    for (std::vector<float>* sum : {&n_, &u_, &v_, &uu_, &uv_, &vv_, &w_, &uw_, &vw_})
      std::fill(sum->begin(), sum->end(), 0.0f);
    const float* const middle = inverse.data() + y * width;
    for (int dv = -kReach; dv <= kReach; ++dv) {
      const auto row = static_cast<std::ptrdiff_t>(y) + dv;
      if (row < 0 || row >= static_cast<std::ptrdiff_t>(height)) continue;
      const float* const other = inverse.data() + row * static_cast<std::ptrdiff_t>(width);
      for (int du = -kReach; du <= kReach; ++du) add(middle, other, width, du, dv);
    }
  }

  /// The plane about pixel x: the inverse depth is `at` there, and grows by `right` and `down` from
  /// pixel to pixel. False if there are too few pixels for a plane.
  bool plane(std::size_t x, float here, float& at, float& right, float& down) const {
    const float n = n_[x];
    const float a = n * uu_[x] - u_[x] * u_[x], b = n * uv_[x] - u_[x] * v_[x],
                c = n * vv_[x] - v_[x] * v_[x];
    const float determinant = a * c - b * b;  // a whole number; 0 if all pixels are in one line
    if (determinant < 0.5f) return false;
    const float p = n * uw_[x] - u_[x] * w_[x], q = n * vw_[x] - v_[x] * w_[x];
    right = (p * c - q * b) / determinant;
    down = (q * a - p * b) / determinant;
    at = here + (w_[x] - right * u_[x] - down * v_[x]) / n;
    return true;
  }

 private:
  /// The pixels of another row that are `du` to the right and `dv` down.
  void add(const float* middle, const float* other, std::size_t width, int du, int dv) {
    const std::size_t begin = du < 0 ? static_cast<std::size_t>(-du) : 0;
    const std::size_t after = du > 0 ? static_cast<std::size_t>(du) : 0;
    if (begin + after >= width) return;
    const std::size_t end = width - after;
    const float share = kDepthJump * static_cast<float>(std::max(std::abs(du), std::abs(dv)));
    const auto u = static_cast<float>(du), v = static_cast<float>(dv);
    // Without a branch, so that four pixels are computed at once.
    for (std::size_t x = begin; x < end; ++x) {
      const float w = other[static_cast<std::ptrdiff_t>(x) + du] - middle[x];
      const float one = std::abs(w) <= share * middle[x] ? 1.0f : 0.0f;
      n_[x] += one;
      u_[x] += one * u;
      v_[x] += one * v;
      uu_[x] += one * (u * u);
      uv_[x] += one * (u * v);
      vv_[x] += one * (v * v);
      w_[x] += one * w;
      uw_[x] += one * u * w;
      vw_[x] += one * v * w;
    }
  }

  std::vector<float> n_, u_, v_, uu_, uv_, vv_, w_, uw_, vw_;
};

/// For each of `count` pixels in a row, the one in a row of `others` that lies over its middle.
std::vector<std::size_t> places(std::size_t count, std::size_t others) {
  std::vector<std::size_t> all(count);
  for (std::size_t i = 0; i < count; ++i) all[i] = (2 * i + 1) * others / (2 * count);
  return all;
}

glm::u16vec3 color_at(const ColorPicture& color, std::size_t x, std::size_t y) {
  const std::uint8_t* const rgb = color.rgb.data() + 3 * (y * color.width + x);
  return glm::u16vec3(rgb[0] * 257, rgb[1] * 257, rgb[2] * 257);
}

}  // namespace

PointCloud depth_points(const DepthPicture& depth, const CameraIntrinsics& camera,
                        const ColorPicture* color) {
  const std::size_t width = depth.width, height = depth.height;
  const InverseDepth inverse = without_flying(inverse_depth(depth), width, height);
  const auto count = static_cast<std::size_t>(
      std::count_if(inverse.begin(), inverse.end(), [](float w) { return w > 0.0f; }));
  PointCloud cloud;
  cloud.positions.reserve(count);
  cloud.normals.reserve(count);
  if (color != nullptr) cloud.colors.reserve(count);
  const auto fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  const double meters = 1.0 / camera.steps_per_meter;
  RowPlanes planes(width);
  const std::vector<std::size_t> columns = places(width, color == nullptr ? 0 : color->width);
  const std::vector<std::size_t> rows = places(height, color == nullptr ? 0 : color->height);
  for (std::size_t y = 0; y < height; ++y) {
    const std::size_t row = rows[y];
    planes.fit(inverse, width, height, y);
    const double v = static_cast<double>(y) - camera.cy, down = v / camera.fy;
    for (std::size_t x = 0; x < width; ++x) {
      const float here = inverse[y * width + x];
      if (here == 0.0f) continue;
      const double u = static_cast<double>(x) - camera.cx, right = u / camera.fx;
      const double ahead = depth.values[y * width + x] * meters;
      const glm::vec3 position(right * ahead, -down * ahead, -ahead);
      cloud.positions.push_back(position);
      float at = 0.0f, to_right = 0.0f, to_bottom = 0.0f;
      glm::vec3 normal = -position;
      // The points (x, y, z) of a plane in camera coordinates, with y down and z ahead, have
      // 1 / z = at + to_right (fx x / z - u) + to_bottom (fy y / z - v), so that their product with
      // the following vector is 1: it points away from the camera.
      if (planes.plane(x, here, at, to_right, to_bottom)) {
        const float z = at - to_right * static_cast<float>(u) - to_bottom * static_cast<float>(v);
        normal = glm::vec3(-to_right * fx, to_bottom * fy, z);
      }
      cloud.normals.push_back(normal);
      if (color != nullptr) cloud.colors.push_back(color_at(*color, columns[x], row));
    }
  }
  for (glm::vec3& normal : cloud.normals) normal = glm::normalize(normal);
  return cloud;
}

}  // namespace pointreel
