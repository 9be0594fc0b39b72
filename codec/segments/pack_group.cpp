#include "codec/segments/pack_group.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "codec/core/build.h"
#include "codec/package/collapse.h"
#include "codec/package/strays.h"
#include "codec/surface/normals.h"
#include "codec/video_encode/video_encoder.h"
#include "common/base/for_each.h"
#include "common/base/try.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

/// The largest side of a view, in levels of an octree, and the smallest, in pixels.
constexpr int kMostLevels = 11, kLeastSide = 16;
/// Where points are not voxels, cells as large as pixels are this share of the points.
constexpr double kMergedShare = 0.6;
/// The edge of a pixel in spacings of cleaned points.
constexpr double kSpacings = 1.25;
/// Pixels that are larger than so many spacings of the points lose most of them.
constexpr double kLossyPixel = 4.0;
/// What is fewer pixels long is not recognised; it is looked for in about so many points.
constexpr double kFewPixels = 16.0;
/// What is shorter as a whole is small because its points are few, and not because some of them are
/// far away.
constexpr double kSmallPixels = 64.0;
constexpr std::size_t kLooked = 4096;
/// VideoOptions::preset without any effort.
constexpr int kFastestPreset = 12;

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
/// surface have a point. There may be more than video can have.
double wanted_side(const PackedFrame& frame) {
  const double edge = frame.grid.cube.edge;
  if (frame.cleaning.cleaned) return edge / (kSpacings * frame.cleaning.spacing);
  const DepthRule& rule = std::get<OctreeOptions>(frame.grid.encode.codec).depth;
  const int level = rule.kind == DepthRule::Kind::fixed ? rule.depth : rule.most;
  if (level < kMaxDepth) return std::exp2(level);
  const PointCloud& cloud = frame.source->cloud;
  const SortedPoints sorted = sort_points(cloud, frame.grid.cube, kMostLevels);
  const double wanted = kMergedShare * static_cast<double>(cloud.size());
  for (std::size_t l = 0; l < kMostLevels; ++l) {
    const double cells = sorted.occupied[l], finer = sorted.occupied[l + 1];
    if (finer >= wanted && finer > cells)
      return std::exp2(static_cast<double>(l) + (wanted - cells) / (finer - cells));
  }
  // Cells of a surface grow fourfold with each level.
  const double cells = std::max(1u, sorted.occupied.back());
  return std::exp2(kMostLevels) * std::sqrt(std::max(1.0, wanted / cells));
}

/// Whether the middle half of some of the points is so few pixels long that it may have collapsed.
bool may_collapse(const PointCloud& cloud, double pitch) {
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / kLooked);
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float> values;
    for (std::size_t i = 0; i < cloud.size(); i += step) values.push_back(cloud.positions[i][axis]);
    std::sort(values.begin(), values.end());
    const std::size_t quarter = values.size() / 4;
    if (values[values.size() - 1 - quarter] - values[quarter] >= kFewPixels * pitch) return false;
  }
  return true;
}

/// Why points are lost, or nothing. Octrees are judged by collapse_of, but pixels have no more than
/// kMostLevels.
std::optional<std::string> why_lost(const PackedFrame& frame, const VideoOptions& video) {
  const PointCloud& cloud = frame.source->cloud;
  if (cloud.empty()) return std::nullopt;
  std::optional<Collapse> collapse;
  if (may_collapse(cloud, video.pitch)) {
    const int level = static_cast<int>(std::ceil(std::log2(video.side)));
    EncodedFrame as_octree;
    as_octree.depth = level;
    as_octree.coded_points =
        static_cast<std::uint32_t>(sort_points(cloud, frame.grid.cube, level).occupied.back());
    collapse = collapse_of(as_octree, cloud, frame.grid, frame.grid.encode, false);
  }
  if (collapse) {
    const glm::dvec3 extent = frame.box.extent();
    const bool is_small = std::max({extent.x, extent.y, extent.z}) < kSmallPixels * video.pitch;
    return fmt::format(
        "its {} points collapse into pixels of {:.3g}, because {}", cloud.size(), video.pitch,
        collapse->far_apart
            ? "the frames of its segment lie too far apart: let fewer share a --segment"
        : is_small ? "they are too few for video"
                   : "some lie too far away, such as " + farthest_text(cloud) + ": remove these");
  }
  if (frame.pixel_spacings > kLossyPixel)
    return fmt::format(
        "its pixels of {:.3g} are {:.3g} times as large as the spacing of its points, because the "
        "points of its segment lie too far apart: let fewer frames share a --segment, or remove "
        "stray points",
        video.pitch, frame.pixel_spacings);
  return std::nullopt;
}

Result<void> judge_loss(PackedFrame& frame, const VideoOptions& video, bool best_effort) {
  const auto why = why_lost(frame, video);
  if (!why) return {};
  const std::string line = fmt::format("{}: {}", frame.name, *why);
  if (!best_effort)
    return fail(ErrorCode::limit,
                line + ", use --codec octree, or --best-effort to pack them nevertheless");
  frame.warnings.push_back(line);
  return {};
}

/// Colours that only some frames of a group have are completed by this grey.
constexpr std::uint16_t kGrey = 0x8080;

/// Frames of a group, which all have normals, and colours if any frame has them.
class CompleteClouds {
 public:
  CompleteClouds(std::span<const PackedFrame> frames, const Executor& executor)
      : completed_(frames.size()), pointers_(frames.size()) {
    const bool colored = std::ranges::any_of(
        frames, [](const PackedFrame& frame) { return frame.source->cloud.has_colors(); });
    for_each(executor, static_cast<int>(frames.size()), [&](int frame) {
      const auto i = static_cast<std::size_t>(frame);
      const PointCloud& source = frames[i].source->cloud;
      pointers_[i] = &source;
      const bool has_normals =
          source.has_normals() &&
          std::ranges::find(source.normals, glm::vec3(0.0f)) == source.normals.end();
      if (has_normals && (source.has_colors() || !colored)) return;
      completed_[i] = source;
      complete_normals(completed_[i], executor);
      if (colored && !source.has_colors())
        completed_[i].colors.assign(source.size(), glm::u16vec3(kGrey));
      pointers_[i] = &completed_[i];
    });
  }
  std::span<const PointCloud* const> pointers() const { return pointers_; }

 private:
  std::vector<PointCloud> completed_;
  std::vector<const PointCloud*> pointers_;
};

}  // namespace

Result<void> pack_group(std::span<PackedFrame> frames, const PackOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  VideoOptions video;
  const Cube& cube = frames.front().grid.cube;
  const double wanted = wanted_side(frames.front());
  video.side = static_cast<int>(std::clamp<double>(wanted, kLeastSide, std::exp2(kMostLevels)));
  for (PackedFrame& frame : frames) {
    frame.video_side = video.side;
    frame.pixel_spacings = wanted / video.side;
  }
  video.pitch = cube.edge / video.side;
  video.preset = kFastestPreset - options.video->effort;
  video.colors = options.encode.colors;
  video.threads = tbb::this_task_arena::max_concurrency();
  video.executor = options.encode.executor;
  set_quantizers(options.video->quality, video);
  for (PackedFrame& frame : frames) TRY(judge_loss(frame, video, options.best_effort));
  const CompleteClouds clouds(frames, options.encode.executor);
  std::vector<Chunks<Bytes>> chunks =
      TRY(encode_video_group(clouds.pointers(), cube.origin, video));
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    PackedFrame& frame = frames[i];
    frame.encode_ms += took.count() / static_cast<double>(frames.size());
    if (frame.parts) {
      frame.parts->geometry += chunks[i].geometry.size();
      frame.parts->colors += chunks[i].colors.size();
    }
    frame.encoded.layers.push_back(std::move(chunks[i]));
  }
  return {};
}

}  // namespace pointreel
