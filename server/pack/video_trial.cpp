#include "server/pack/video_trial.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "codec/package/coarsening.h"
#include "codec/segments/coding_error.h"
#include "codec/segments/input.h"
#include "codec/segments/pack_frame.h"
#include "codec/segments/pack_group.h"
#include "codec/segments/pack_segment.h"
#include "common/base/try.h"
#include "common/file_system/output_folder.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

/// More points than the pixels of all views show no more, and several such frames are held.
constexpr std::size_t kMostPoints = 8'000'000;
/// One frame in so many is tried. Each takes about as long as five frames of octrees.
constexpr std::size_t kTriedOneIn = 48, kFewestTriedFrames = 3, kMostTriedFrames = 8;
/// By how much the quality of the octree's colours is lowered until they are no better than those
/// of the video; then by twice as much, and so on.
constexpr int kFirstStep = 4;

/// Where pixels are larger than so many spacings of the points, or the mean square of the error is
/// so many times that of the trial, a segment is not like the frames that were tried.
constexpr double kLargestPixel = 1.5, kWorse = 4.0;

/// The bytes of a frame of a whole group. Of frames that were encoded as a group, the first stands
/// for itself and each other one for those of which there are more.
double bytes_in_group(std::span<const PackedFrame> frames, std::uint32_t group_frames) {
  double others = 0.0;
  for (const PackedFrame& frame : frames.subspan(1))
    others += static_cast<double>(frame.encoded.size());
  others /= static_cast<double>(frames.size() - 1);
  return (static_cast<double>(frames.front().encoded.size()) + others * (group_frames - 1)) /
         group_frames;
}

bool has_scalars(const PointCloud& cloud, const PackOptions& options) {
  return cloud.has_scalars() && std::get<OctreeOptions>(options.encode.codec).scalars;
}

/// Both, as VideoTrial says. Nothing if there is nothing to compare.
Result<std::optional<VideoTrial>> compare(SegmentInput& input, const PackOptions& options,
                                          const std::stop_token& stop) {
  TRY(input.find_shared_grid(stop));
  for (std::size_t i = 0; i < input.size(); ++i)
    if (has_scalars(TRY(input.look(i))->cloud, options)) return std::nullopt;
  const Grid& grid = *input.shared_grid();
  const std::size_t middle = input.size() / 2;
  const SegmentInput::Cloud source = TRY(input.look(middle));
  const PointCloud& cloud = source->cloud;
  PackOptions as_video = options;
  as_video.pack_as_video(*options.video_if_it_pays);
  FrameLimits limits(as_video);
  std::vector<PackedFrame> frames;
  for (std::size_t i = 0; i < input.size() && !stop.stop_requested(); ++i)
    frames.push_back(TRY(pack_frame(input, i, as_video, limits, true)));
  if (stop.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);
  TRY(pack_group(frames, as_video));

  const auto video_error = TRY(coding_error(std::span(frames).first(middle + 1), as_video));
  if (!video_error) return std::nullopt;

  const int depth = static_cast<int>(std::lround(std::log2(frames.front().video_side))) - 1;
  EncodeOptions coarser = no_deeper_than(grid.encode, std::max(depth, kCoarsestDepth));
  coarser.normals = false;  // video has none either
  PackedFrame octree;
  octree.source = source;
  std::optional<CodingError> octree_error;
  auto& quality = std::get<OctreeOptions>(coarser.codec).color_quality;
  for (int less = kFirstStep;; less *= 2) {
    octree.encoded = TRY(encode_frame(cloud, grid.cube, coarser));
    octree_error = TRY(coding_error(std::span(&octree, 1), options));
    if (!octree_error) return std::nullopt;
    const bool is_better =
        octree_error->luma && video_error->luma && *octree_error->luma < *video_error->luma;
    if (!is_better || quality == 1) break;
    quality = std::max(1, quality - less);
  }
  return VideoTrial{frames.size(),
                    grid.cube.edge,
                    quality,
                    {bytes_in_group(frames, as_video.video->group_frames), *video_error},
                    {static_cast<double>(octree.encoded.size()), *octree_error}};
}

/// The trial of PackOptions::video_if_it_pays. Nothing if it is not worth making.
Result<std::optional<VideoTrial>> try_video(std::span<const CloudFrame> frames,
                                            const PackOptions& options,
                                            const std::stop_token& stop) {
  if (frames.size() < kFewestVideoFrames) return std::nullopt;
  const std::size_t count =
      std::clamp(frames.size() / kTriedOneIn, kFewestTriedFrames, kMostTriedFrames);
  const SourceFrames sources(frames, options);
  SegmentInput input(sources, (frames.size() - count) / 2, count, options);
  {
    const SegmentInput::Cloud first = TRY(input.look(0));
    const std::size_t points = first->cloud.size();
    if (points < kFewestVideoPoints || points > kMostPoints) return std::nullopt;
  }
  return compare(input, options, stop);
}

}  // namespace

Result<void> VideoTrial::holds_for(const PackedSegment& segment, const PackOptions& options) const {
  const auto fails = [&](const std::string& why) {
    const SegmentSummary& of = segment.summary;
    return fail(ErrorCode::limit, fmt::format("frames {} to {} {}", of.first_frame,
                                              of.first_frame + of.frames - 1, why));
  };
  if (segment.pixel_spacings > kLargestPixel)
    return fails(
        fmt::format("need pixels that are {:.3g} times as large as the spacing of their points",
                    segment.pixel_spacings));
  if (segment.had_scalars && std::get<OctreeOptions>(options.encode.codec).scalars)
    return fails("have scalar fields");
  if (!segment.summary.within_rate) return fails("exceed the bit rate");
  const auto much_worse = [](std::optional<double> later, std::optional<double> tried) {
    return later && tried && *later > kWorse * *tried;
  };
  if (segment.coding_error && (much_worse(segment.coding_error->d1, video.error.d1) ||
                               much_worse(segment.coding_error->d2, video.error.d2)))
    return fails("are much farther from their source than those of the trial");
  return {};
}

bool VideoTrial::video_pays() const {
  const auto no_worse = [](const auto& one, const auto& other) {
    return !other || (one && *one <= *other);
  };
  return video.bytes < octrees.bytes && no_worse(video.error.d2, octrees.error.d2) &&
         no_worse(video.error.luma, octrees.error.luma);
}

Result<std::optional<VideoTrial>> choose_video(std::span<const CloudFrame> frames,
                                               PackOptions& options, const std::stop_token& stop) {
  if (!options.video_if_it_pays || options.cube_per_frame) return std::nullopt;
  auto tried = try_video(frames, options, stop);
  if (stop.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);
  // What cannot be read will be said when it is packed.
  if (!tried || !*tried) return std::nullopt;
  if ((*tried)->video_pays()) options.pack_as_video(*options.video_if_it_pays);
  return tried;
}

std::vector<std::string> trial_lines(const VideoTrial& trial) {
  const auto line = [&](const std::string& what, const VideoTrial::Outcome& outcome) {
    return fmt::format("    {}: {:.0f} bytes a frame, {}", what, outcome.bytes,
                       coding_error_text(outcome.error, trial.peak));
  };
  return {fmt::format("  chosen          {}, by a trial on {} frames (--codec overrides)",
                      trial.video_pays() ? "video" : "octrees", trial.frames),
          line("video", trial.video),
          line(fmt::format("octrees, voxels of two pixels, quality {}", trial.octree_quality),
               trial.octrees)};
}

nlohmann::ordered_json trial_json(const std::optional<VideoTrial>& trial) {
  if (!trial) return nullptr;
  const auto json = [&](const VideoTrial::Outcome& outcome) {
    return nlohmann::ordered_json{{"bytes_per_frame", outcome.bytes},
                                  {"coding_error", coding_error_json(outcome.error, trial->peak)}};
  };
  return {{"frames", trial->frames},
          {"video_pays", trial->video_pays()},
          {"video", json(trial->video)},
          {"octrees_of_two_pixels", json(trial->octrees)},
          {"octrees_quality", trial->octree_quality}};
}

}  // namespace pointreel
