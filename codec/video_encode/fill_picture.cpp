#include "codec/video_encode/fill_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

namespace pointreel {
namespace {

/// How far patches are continued, and how far the pixels are away that tell how, in pixels.
constexpr int kRim = 4, kAround = kRim + 3;
constexpr int kLeastPixels = 6;
/// Keeps the slopes of planes that few pixels tell of small.
constexpr float kFlatten = 0.02f;

struct Area {
  int left, top, right, bottom;
};
Area area_of(const Patch& patch, int divisor) {
  return {patch.atlas_x / divisor, patch.atlas_y / divisor, (patch.atlas_x + patch.width) / divisor,
          (patch.atlas_y + patch.height) / divisor};
}

/// The pixels around one within kRim, nearest first, and how much each within kAround counts.
struct Around {
  struct Offset {
    int u, v;
  };
  std::vector<Offset> nearest;
  std::array<std::array<float, 2 * kAround + 1>, 2 * kAround + 1> weights;

  Around() {
    const auto square = [](const Offset& o) { return o.u * o.u + o.v * o.v; };
    for (int v = -kRim; v <= kRim; ++v)
      for (int u = -kRim; u <= kRim; ++u)
        if (square({u, v}) <= kRim * kRim) nearest.push_back({u, v});
    std::stable_sort(nearest.begin(), nearest.end(),
                     [&](const Offset& a, const Offset& b) { return square(a) < square(b); });
    for (int v = -kAround; v <= kAround; ++v)
      for (int u = -kAround; u <= kAround; ++u)
        weights[static_cast<std::size_t>(v + kAround)][static_cast<std::size_t>(u + kAround)] =
            1.0f / static_cast<float>(1 + u * u + v * v);
  }
};

/// The value at a pixel of the plane that fits the known pixels around it that are on the surface
/// of the nearest one; nothing if none is near.
std::optional<float> continued(const Plane& plane, const Area& area, const Around& around, int x,
                               int y, float jump) {
  const auto nearest =
      std::find_if(around.nearest.begin(), around.nearest.end(), [&](const Around::Offset& o) {
        const int u = x + o.u, v = y + o.v;
        return u >= area.left && u < area.right && v >= area.top && v < area.bottom &&
               plane.known[plane.at(u, v)] != 0;
      });
  if (nearest == around.nearest.end()) return std::nullopt;
  // Relative to the nearest value, so that single precision does.
  const float anchor = plane.values[plane.at(x + nearest->u, y + nearest->v)];
  float w = 0, wx = 0, wy = 0, wxx = 0, wxy = 0, wyy = 0, wz = 0, wxz = 0, wyz = 0;
  float least = 0.0f, most = 0.0f;
  int count = 0;
  const int left = std::max(area.left, x - kAround), right = std::min(area.right, x + kAround + 1);
  for (int v = std::max(area.top, y - kAround); v < std::min(area.bottom, y + kAround + 1); ++v) {
    const std::uint8_t* const known = &plane.known[plane.at(0, v)];
    const float* const values = &plane.values[plane.at(0, v)];
    const auto& weights = around.weights[static_cast<std::size_t>(v - y + kAround)];
    const auto dy = static_cast<float>(v - y);
    for (int u = left; u < right; ++u) {
      const float z = values[u] - anchor;
      if (known[u] == 0 || std::abs(z) > jump) continue;
      const float weight = weights[static_cast<std::size_t>(u - x + kAround)];
      const auto dx = static_cast<float>(u - x);
      w += weight;
      wx += weight * dx;
      wy += weight * dy;
      wxx += weight * dx * dx;
      wxy += weight * dx * dy;
      wyy += weight * dy * dy;
      wz += weight * z;
      wxz += weight * dx * z;
      wyz += weight * dy * z;
      least = std::min(least, z);
      most = std::max(most, z);
      ++count;
    }
  }
  if (count < kLeastPixels) return anchor;
  const float mx = wx / w, my = wy / w, mz = wz / w;
  const float xx = wxx / w - mx * mx + kFlatten, yy = wyy / w - my * my + kFlatten,
              xy = wxy / w - mx * my;
  const float xz = wxz / w - mx * mz, yz = wyz / w - my * mz, determinant = xx * yy - xy * xy;
  const float sx = (xz * yy - yz * xy) / determinant, sy = (yz * xx - xz * xy) / determinant;
  const float value = mz - sx * mx - sy * my;
  return anchor + std::clamp(value, least - 0.5f * jump, most + 0.5f * jump);
}

/// Values with weights from 0 to 1.
struct Level {
  int width, height;
  std::vector<float> values, weights;

  Level(int w, int h)
      : width(w),
        height(h),
        values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)),
        weights(values.size()) {}
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

Level pulled(const Level& fine) {
  Level coarse((fine.width + 1) / 2, (fine.height + 1) / 2);
  for (int y = 0; y < coarse.height; ++y) {
    float* const values = &coarse.values[coarse.at(0, y)];
    float* const weights = &coarse.weights[coarse.at(0, y)];
    for (int line = 2 * y; line < std::min(2 * y + 2, fine.height); ++line) {
      const float* const from = &fine.values[fine.at(0, line)];
      const float* const by = &fine.weights[fine.at(0, line)];
      for (int x = 0; x < fine.width / 2; ++x) {
        values[x] += by[2 * x] * from[2 * x] + by[2 * x + 1] * from[2 * x + 1];
        weights[x] += by[2 * x] + by[2 * x + 1];
      }
      if (fine.width % 2 != 0) {
        values[coarse.width - 1] += by[fine.width - 1] * from[fine.width - 1];
        weights[coarse.width - 1] += by[fine.width - 1];
      }
    }
    for (int x = 0; x < coarse.width; ++x) {
      values[x] /= std::max(weights[x], 1e-9f);
      weights[x] = std::min(weights[x], 1.0f);
    }
  }
  return coarse;
}

/// Gives pixels what the coarser level has around them, as far as their own weight leaves room.
void push(const Level& coarse, Level& fine) {
  std::vector<float> lines(static_cast<std::size_t>(coarse.width) + 2);
  std::vector<float> line(static_cast<std::size_t>(fine.width) + 1);
  float* const inner = lines.data() + 1;  // with a pixel repeated at both ends
  for (int y = 0; y < fine.height; ++y) {
    // The centre of a pixel lies a quarter of a coarse one off the centre of its own.
    const int own = y / 2, other = std::clamp(own + (y % 2 == 0 ? -1 : 1), 0, coarse.height - 1);
    const float* const at_own = &coarse.values[coarse.at(0, own)];
    const float* const at_other = &coarse.values[coarse.at(0, other)];
    for (int x = 0; x < coarse.width; ++x) inner[x] = 0.75f * at_own[x] + 0.25f * at_other[x];
    inner[-1] = inner[0];
    inner[coarse.width] = inner[coarse.width - 1];
    for (int x = 0; x < (fine.width + 1) / 2; ++x) {
      const auto i = static_cast<std::size_t>(2 * x);
      line[i] = 0.75f * inner[x] + 0.25f * inner[x - 1];
      line[i + 1] = 0.75f * inner[x] + 0.25f * inner[x + 1];
    }
    float* const values = &fine.values[fine.at(0, y)];
    const float* const weights = &fine.weights[fine.at(0, y)];
    for (int x = 0; x < fine.width; ++x)
      values[x] = weights[x] * values[x] + (1.0f - weights[x]) * line[static_cast<std::size_t>(x)];
  }
}

}  // namespace

void continue_patches(const VideoGroup& group, float jump, Plane& plane) {
  struct Continued {
    std::size_t pixel;
    float value;
  };
  std::vector<Continued> all;
  const Around around;
  // How many known pixels there are above and to the left: most of a patch is far from its rim.
  const auto row = static_cast<std::size_t>(plane.width) + 1;
  std::vector<std::uint32_t> sums(row * (static_cast<std::size_t>(plane.height) + 1), 0);
  for (int y = 0; y < plane.height; ++y) {
    std::uint32_t sum = 0;
    for (int x = 0; x < plane.width; ++x) {
      sum += plane.known[plane.at(x, y)];
      sums[static_cast<std::size_t>(y + 1) * row + static_cast<std::size_t>(x) + 1] =
          sums[static_cast<std::size_t>(y) * row + static_cast<std::size_t>(x) + 1] + sum;
    }
  }
  for (const Patch& patch : group.patches) {
    const Area area = area_of(patch, 1);
    for (int y = area.top; y < area.bottom; ++y) {
      const auto top = static_cast<std::size_t>(std::max(area.top, y - kRim)),
                 bottom = static_cast<std::size_t>(std::min(area.bottom, y + kRim + 1));
      for (int x = area.left; x < area.right; ++x) {
        if (plane.known[plane.at(x, y)] != 0) continue;
        const auto left = static_cast<std::size_t>(std::max(area.left, x - kRim)),
                   right = static_cast<std::size_t>(std::min(area.right, x + kRim + 1));
        if (sums[bottom * row + right] + sums[top * row + left] ==
            sums[top * row + right] + sums[bottom * row + left])
          continue;
        if (const auto value = continued(plane, area, around, x, y, jump))
          all.push_back({plane.at(x, y), *value});
      }
    }
  }
  for (const Continued& pixel : all) {
    plane.values[pixel.pixel] = pixel.value;
    plane.known[pixel.pixel] = 1;
  }
}

void fill_patches(const VideoGroup& group, int divisor, const Plane* background, const Plane* next,
                  Plane& plane) {
  constexpr float kBackground = 0.02f;
  for (const Patch& patch : group.patches) {
    const Area area = area_of(patch, divisor);
    std::vector<Level> levels{Level(area.right - area.left, area.bottom - area.top)};
    for (int y = area.top; y < area.bottom; ++y) {
      for (int x = area.left; x < area.right; ++x) {
        const std::size_t from = plane.at(x, y), to = levels[0].at(x - area.left, y - area.top);
        const Plane* const known = plane.known[from] != 0                      ? &plane
                                   : next != nullptr && next->known[from] != 0 ? next
                                                                               : nullptr;
        if (known != nullptr) {
          levels[0].values[to] = known->values[from];
          levels[0].weights[to] = 1.0f;
        } else if (background != nullptr) {
          levels[0].values[to] = background->values[from];
          levels[0].weights[to] = kBackground;
        }
      }
    }
    while (levels.back().width > 1 || levels.back().height > 1)
      levels.push_back(pulled(levels.back()));
    for (std::size_t l = levels.size() - 1; l-- > 0;) push(levels[l + 1], levels[l]);
    for (int y = area.top; y < area.bottom; ++y)
      for (int x = area.left; x < area.right; ++x)
        if (plane.known[plane.at(x, y)] == 0)
          plane.values[plane.at(x, y)] =
              levels[0].values[levels[0].at(x - area.left, y - area.top)];
  }
}

}  // namespace pointreel
