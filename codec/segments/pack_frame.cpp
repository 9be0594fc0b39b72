#include "codec/segments/pack_frame.h"

#include <algorithm>
#include <chrono>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "codec/core/scalar_fields.h"
#include "codec/draco/part_sizes.h"
#include "codec/package/collapse.h"
#include "codec/package/max_error.h"
#include "common/base/try.h"
#include "common/base/words.h"

namespace pointreel {
namespace {

/// More points than this in a voxel are not meant to share it.
constexpr std::size_t kPointsInVoxel = 1000;

/// Colours of the octree that video stands on need not be better than a small picture shows. With
/// 30, which takes 0.09 Mbit/s less, grey cloth turned green and faces pink.
constexpr int kVideoBaseQuality = 45;

/// How the octree is encoded that video stands on.
EncodeOptions base_options(const EncodeOptions& asked) {
  EncodeOptions options = no_deeper_than(asked, kVideoBaseLevel);
  options.normals = false;
  auto& octree = std::get<OctreeOptions>(options.codec);
  octree.color_quality = std::min(octree.color_quality, kVideoBaseQuality);
  octree.scalars = false;
  return options;
}

/// Encodes `cloud` into `frame`. Returns the options that were used.
Result<EncodeOptions> encode(PackedFrame& frame, const PointCloud& cloud, const Grid& grid,
                             const PackOptions& options, FrameLimits& limits) {
  EncodeOptions encode_options = limits.of_frame(grid.encode);
  if (options.video) encode_options = base_options(encode_options);
  const auto start = std::chrono::steady_clock::now();
  frame.encoded = TRY(encode_frame(cloud, grid.cube, encode_options));
  frame.encode_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  limits.told(frame.encoded.depth, frame.encode_ms);
  frame.max_error = geometry_error(cloud, grid.cube, frame.encoded.depth);
  // The parts of an octree are only counted; those of Draco take more encodes.
  if (encode_options.id() == Codec::octree || options.measure_parts) {
    frame.parts = TRY(measure_part_sizes(frame.encoded, cloud, grid.cube, encode_options));
  }
  return encode_options;
}

/// A frame that collapses is an error, or a warning. `strays`: of the frames that share its grid.
Result<void> judge_collapse(PackedFrame& frame, const std::string& file, const PointCloud& cloud,
                            const Grid& grid, const std::string& strays, const EncodeOptions& used,
                            bool best_effort) {
  const std::optional<Collapse> collapse =
      collapse_of(frame.encoded, cloud, grid, used, !strays.empty());
  if (!collapse) return {};
  const std::string why =
      fmt::format("{}, because {}: {}", collapse->what, collapse->why,
                  collapse->far_apart ? "let fewer frames share a --segment, or give --cube frame"
                                      : "remove these");
  if (best_effort) {
    frame.warnings.push_back(why);
    return {};
  }
  if (!strays.empty())
    return fail(ErrorCode::limit, fmt::format("{} ({}: {})", strays, file, collapse->what));
  return fail(ErrorCode::limit,
              fmt::format("{}: {}, or --best-effort to pack them nevertheless", file, why));
}

/// Warns of scalar fields whose range is too large for the steps that were asked for.
void tell_coarse_steps(PackedFrame& frame, std::span<const ScalarStep> steps) {
  for (const ScalarRange& range : frame.scalars) {
    const auto asked = std::ranges::find(steps, range.name, &ScalarStep::name);
    const double finest = (range.most - range.least) / kMostScalarSteps;
    if (asked == steps.end() || asked->step >= finest) continue;
    frame.warnings.push_back(fmt::format(
        "--scalar-step {}={:g}: its values from {:g} to {:g} are kept in steps of {:g}, "
        "the finest that there are",
        range.name, asked->step, range.least, range.most, finest));
  }
}

}  // namespace

Result<PackedFrame> pack_frame(SegmentInput& input, std::size_t index, const PackOptions& options,
                               FrameLimits& limits, bool keep_source) {
  const SegmentInput::Cloud loaded = TRY(input.take(index));
  const PointCloud& cloud = loaded->cloud;
  const std::string file = input.name(index);
  PackedFrame frame;
  frame.box = bounds(cloud);
  frame.colors = options.encode.colors && cloud.has_colors();
  frame.normals = options.encode.normals && cloud.has_normals();
  frame.normals_estimated = loaded->normals_estimated;
  frame.had_radii = cloud.has_radii();
  frame.had_scalars = cloud.has_scalars();
  frame.cleaning = loaded->cleaning;
  frame.unread = loaded->unread;
  frame.warnings = loaded->warnings;
  frame.unreadable = loaded->unreadable;
  const Result<Grid> grid = input.grid_of(*loaded);
  if (!grid && !loaded->strays.empty())
    return fail(ErrorCode::limit, fmt::format("{} ({})", loaded->strays, grid.error().message));
  if (!grid) return fail_at(file, grid.error());
  const auto used = encode(frame, cloud, *grid, options, limits);
  if (!used) return fail_at(file, used.error());
  if (keep_source || options.video) frame.source = loaded;
  if (options.video) {
    frame.name = file;
    frame.grid = *grid;
    frame.max_error = 0.0;
  } else if (options.voxel) {
    if (cloud.size() > kPointsInVoxel * frame.encoded.coded_points)
      frame.warnings.push_back(fmt::format(
          "its {} points fall into {} of this size: --voxel is in the units of the points",
          cloud.size(), counted(frame.encoded.coded_points, "voxel")));
  } else {
    TRY(judge_collapse(frame, file, cloud, *grid, input.strays_of(*loaded), *used,
                       options.best_effort));
  }
  if (frame.encoded.has_scalars) {
    frame.scalars = ranges_of(cloud);
    tell_coarse_steps(frame, std::get<OctreeOptions>(options.encode.codec).scalar_steps);
  }
  for (std::string& warning : frame.warnings) warning = fmt::format("{}: {}", file, warning);
  return frame;
}

}  // namespace pointreel
