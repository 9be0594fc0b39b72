#include "server/pack/pack_group.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <tbb/task_arena.h>

#include "codec/core/build.h"
#include "codec/surface/normals.h"
#include "codec/video_encode/video_encoder.h"
#include "common/base/for_each.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

/// The largest side of a view, in levels of an octree, and the smallest, in pixels.
constexpr int kMostLevels = 11, kLeastSide = 16;
/// Where points are not voxels, cells as large as pixels are this share of the points.
constexpr double kMergedShare = 0.6;
/// The edge of a pixel in spacings of cleaned points.
constexpr double kSpacings = 1.25;

/// Quantisers that go together. QUALITY.md, "Video", gives rate and error of each pair.
struct Quantizers {
  int quality, depth, color;
};
constexpr std::array<Quantizers, 7> kQuantizers{{{1, 44, 56},
                                                 {20, 28, 46},
                                                 {30, 20, 43},
                                                 {40, 16, 41},
                                                 {50, 12, 37},
                                                 {64, 8, 32},
                                                 {100, 3, 12}}};

void set_quantizers(int quality, VideoOptions& options) {
  for (std::size_t i = 1; i < kQuantizers.size(); ++i) {
    const Quantizers &low = kQuantizers[i - 1], &high = kQuantizers[i];
    if (quality > high.quality) continue;
    const double share = static_cast<double>(quality - low.quality) / (high.quality - low.quality);
    options.depth_quantizer =
        static_cast<int>(std::lround(std::lerp(low.depth, high.depth, share)));
    options.color_quantizer =
        static_cast<int>(std::lround(std::lerp(low.color, high.color, share)));
    return;
  }
}

/// Pixels along the cube: those of the voxels of the source, or so many that most pixels of a
/// surface have a point.
int side_of(const PackedFrame& frame) {
  const double edge = frame.grid.cube.edge;
  if (frame.cleaning.cleaned) return static_cast<int>(edge / (kSpacings * frame.cleaning.spacing));
  const DepthRule& rule = std::get<OctreeOptions>(frame.grid.encode.codec).depth;
  const int level = rule.kind == DepthRule::Kind::fixed ? rule.depth : rule.most;
  if (level < kMaxDepth) return 1 << std::min(level, kMostLevels);
  const PointCloud& cloud = frame.source->cloud;
  const SortedPoints sorted = sort_points(cloud, frame.grid.cube, kMostLevels);
  const double wanted = kMergedShare * static_cast<double>(cloud.size());
  for (std::size_t l = 0; l < kMostLevels; ++l) {
    const double cells = sorted.occupied[l], finer = sorted.occupied[l + 1];
    if (finer >= wanted && finer > cells)
      return static_cast<int>(
          std::exp2(static_cast<double>(l) + (wanted - cells) / (finer - cells)));
  }
  return 1 << kMostLevels;
}

}  // namespace

Result<std::vector<Chunks<Bytes>>> pack_group(std::span<const PackedFrame> frames,
                                              const PackOptions& options) {
  VideoOptions video;
  const Cube& cube = frames.front().grid.cube;
  video.side = std::clamp(side_of(frames.front()), kLeastSide, 1 << kMostLevels);
  video.pitch = cube.edge / video.side;
  video.preset = options.video->preset;
  video.colors = options.encode.colors;
  video.threads = tbb::this_task_arena::max_concurrency();
  video.executor = options.encode.executor;
  set_quantizers(options.video->quality, video);
  std::vector<PointCloud> clouds(frames.size());
  for_each(options.encode.executor, static_cast<int>(frames.size()), [&](int i) {
    PointCloud& cloud = clouds[static_cast<std::size_t>(i)];
    cloud = frames[static_cast<std::size_t>(i)].source->cloud;
    cloud.has_normals() ? complete_normals(cloud) : estimate_normals(cloud);
  });
  return encode_video_group(clouds, cube.origin, video);
}

}  // namespace pointreel
