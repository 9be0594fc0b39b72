#include "codec/video_encode/depth_plane.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace pointreel {
namespace {

/// Points of a column belong to one passage of the surface within so many pixels.
constexpr float kThick = 2.0f;
/// How far a point may lie from where its neighbours continue to.
constexpr float kContinues = 3.1f;
constexpr int kRounds = 2 * kBlock;
/// The finest steps of depth, to a pixel, and how much room is left at both ends, in pixels: coding
/// does not keep exact values, and patches are continued beyond what is known.
constexpr float kFinestSteps = 4.0f, kRoom = 8.0f;

std::size_t at(const VideoGroup& group, const Patch& patch, int x, int y) {
  return static_cast<std::size_t>(patch.atlas_y + y) * static_cast<std::size_t>(group.width) +
         static_cast<std::size_t>(patch.atlas_x + x);
}

/// A patch while its depth is found.
class DepthOfPatch {
 public:
  DepthOfPatch(const VideoGroup& group, const Patch& patch, const SurfacePoints& points,
               std::vector<float>& depth)
      : group_(group),
        patch_(patch),
        points_(points),
        axis_(patch.view / 2),
        columns_(points.columns[static_cast<std::size_t>(axis_)]),
        depth_(depth) {}

  void take(const ViewLayer& layer) {
    for_each_pixel([&](int x, int y) { of(x, y) = layer.at(patch_.x + x, patch_.y + y); });
  }

  void fill(const std::vector<std::uint8_t>& mask) {
    struct Pixel {
      int x, y;
    };
    std::vector<Pixel> open;
    for_each_pixel([&](int x, int y) {
      const std::size_t p = at(group_, patch_, x, y);
      if (mask[p] != 0 && depth_[p] == ViewLayer::kNone) open.push_back({x, y});
    });
    struct Found {
      float* depth;
      float value;
    };
    std::vector<Found> found;
    for (int round = 0; round < kRounds; ++round) {
      found.clear();
      std::erase_if(open, [&](const Pixel& pixel) {
        const float expected = mean_around(pixel.x, pixel.y);
        if (expected == ViewLayer::kNone) return false;
        const float value = nearest(pixel.x, pixel.y, expected);
        if (value == ViewLayer::kNone) return false;
        found.push_back({&of(pixel.x, pixel.y), value});
        return true;
      });
      if (found.empty()) return;
      for (const Found& f : found) *f.depth = f.value;
    }
  }

  void center() {
    for_each_pixel([&](int x, int y) {
      float& depth = of(x, y);
      if (depth == ViewLayer::kNone) return;
      float sum = 0.0f, count = 0.0f;
      for (std::size_t k = columns_.first(pixel(x, y)); k < columns_.end(pixel(x, y)); ++k) {
        const float other = points_.places[columns_.points[k]][axis_];
        if (std::abs(other - depth) > kThick) continue;
        sum += other;
        ++count;
      }
      if (count > 0.0f) depth = sum / count;
    });
  }

 private:
  template <class Body>
  void for_each_pixel(const Body& body) {
    for (int y = 0; y < patch_.height; ++y)
      for (int x = 0; x < patch_.width; ++x) body(x, y);
  }

  float& of(int x, int y) { return depth_[at(group_, patch_, x, y)]; }
  std::size_t pixel(int x, int y) const {
    return static_cast<std::size_t>(patch_.y + y) * static_cast<std::size_t>(points_.side) +
           static_cast<std::size_t>(patch_.x + x);
  }

  float mean_around(int x, int y) {
    float sum = 0.0f, count = 0.0f;
    for (int v = std::max(0, y - 1); v <= std::min(patch_.height - 1, y + 1); ++v) {
      for (int u = std::max(0, x - 1); u <= std::min(patch_.width - 1, x + 1); ++u) {
        if (of(u, v) == ViewLayer::kNone) continue;
        sum += of(u, v);
        ++count;
      }
    }
    return count > 0.0f ? sum / count : ViewLayer::kNone;
  }

  float nearest(int x, int y, float expected) const {
    if (patch_.x + x >= points_.side || patch_.y + y >= points_.side) return ViewLayer::kNone;
    float best = ViewLayer::kNone, least = kContinues;
    for (std::size_t k = columns_.first(pixel(x, y)); k < columns_.end(pixel(x, y)); ++k) {
      const float depth = points_.places[columns_.points[k]][axis_];
      if (std::abs(depth - expected) >= least) continue;
      least = std::abs(depth - expected);
      best = depth;
    }
    return best;
  }

  const VideoGroup& group_;
  const Patch& patch_;
  const SurfacePoints& points_;
  int axis_;
  const SurfacePoints::Columns& columns_;
  std::vector<float>& depth_;
};

}  // namespace

BlockMask blocks_of(const VideoGroup& group, const ViewLayers& layers) {
  BlockMask blocks(group);
  for (const Patch& patch : group.patches) {
    const ViewLayer& layer =
        layers[static_cast<std::size_t>(patch.view)][static_cast<std::size_t>(patch.layer)];
    if (!layer.used()) continue;
    layer.for_each([&](int x, int y, float) {
      blocks.at((patch.atlas_x + x - patch.x) / kBlock, (patch.atlas_y + y - patch.y) / kBlock) = 1;
    });
  }
  return blocks;
}

std::vector<float> middle_depth(const VideoGroup& group, const ViewLayers& layers,
                                const SurfacePoints& points,
                                const std::vector<std::uint8_t>& mask) {
  std::vector<float> depth(group.pixels(), ViewLayer::kNone);
  for (const Patch& patch : group.patches) {
    DepthOfPatch of(group, patch, points, depth);
    of.take(layers[static_cast<std::size_t>(patch.view)][static_cast<std::size_t>(patch.layer)]);
    of.fill(mask);
    of.center();
  }
  return depth;
}

void choose_depth_steps(std::span<const std::vector<float>> frames, VideoGroup& group) {
  std::array<float, kViews> least, most;
  least.fill(std::numeric_limits<float>::max());
  most.fill(std::numeric_limits<float>::lowest());
  for (const std::vector<float>& depth : frames) {
    for (const Patch& patch : group.patches) {
      const auto v = static_cast<std::size_t>(patch.view);
      for (int y = 0; y < patch.height; ++y) {
        for (int x = 0; x < patch.width; ++x) {
          const float value = depth[at(group, patch, x, y)];
          if (value == ViewLayer::kNone) continue;
          least[v] = std::min(least[v], value);
          most[v] = std::max(most[v], value);
        }
      }
    }
  }
  for (std::size_t v = 0; v < kViews; ++v) {
    if (least[v] > most[v]) continue;
    const float range = most[v] - least[v] + 2.0f * kRoom;
    group.depth[v] = {std::floor(least[v] - kRoom),
                      std::min(kFinestSteps, static_cast<float>(kDepthValues - 4) / range)};
  }
}

}  // namespace pointreel
