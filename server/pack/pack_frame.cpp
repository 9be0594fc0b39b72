#include "server/pack/pack_frame.h"

#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "codec/max_error.h"
#include "codec/part_sizes.h"
#include "common/base/try.h"
#include "common/cloud/scalar_fields.h"
#include "server/pack/collapse.h"

namespace pointreel {
namespace {

/// Encodes `cloud` into `frame`.
Result<void> encode(PackedFrame& frame, const PointCloud& cloud, const Grid& grid,
                    const PackOptions& options, FrameLimits& limits) {
  const EncodeOptions encode_options = limits.of_frame(grid.encode);
  const auto start = std::chrono::steady_clock::now();
  frame.encoded = TRY(encode_frame(cloud, grid.cube, encode_options));
  frame.encode_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  limits.told(frame.encoded.depth, frame.encode_ms);
  frame.max_error = geometry_error(cloud, grid.cube, frame.encoded.depth);
  if (!options.voxel) {
    if (auto collapse = collapse_of(frame.encoded, cloud, grid, encode_options)) {
      if (!options.best_effort) {
        return fail(ErrorCode::limit, *collapse + ", or --best-effort to pack them nevertheless");
      }
      frame.warnings.push_back(std::move(*collapse));
    }
  }
  // The parts of an octree are only counted; those of Draco take more encodes.
  if (encode_options.id() == Codec::octree || options.measure_parts) {
    frame.parts = TRY(measure_part_sizes(frame.encoded, cloud, grid.cube, encode_options));
  }
  return {};
}

}  // namespace

Result<PackedFrame> pack_frame(SegmentInput& input, std::size_t index, const PackOptions& options,
                               FrameLimits& limits) {
  const SegmentInput::Cloud loaded = TRY(input.take(index));
  const PointCloud& cloud = loaded->cloud;
  const std::string file = input.name(index);
  PackedFrame frame;
  frame.box = bounds(cloud);
  frame.colors = options.encode.colors && cloud.has_colors();
  frame.normals = options.encode.normals && cloud.has_normals();
  frame.had_radii = cloud.has_radii();
  frame.had_scalars = cloud.has_scalars();
  frame.cleaning = loaded->cleaning;
  frame.unread = loaded->unread;
  frame.warnings = loaded->warnings;
  const Result<Grid> grid = input.grid_of(*loaded);
  if (!grid) return fail_at(file, grid.error());
  if (const auto encoded = encode(frame, cloud, *grid, options, limits); !encoded) {
    return fail_at(file, encoded.error());
  }
  if (frame.encoded.has_scalars) frame.scalars = ranges_of(cloud);
  for (std::string& warning : frame.warnings) warning = fmt::format("{}: {}", file, warning);
  return frame;
}

}  // namespace pointreel
