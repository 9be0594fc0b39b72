#include "server/pack/pack_frame.h"

#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "codec/max_error.h"
#include "codec/part_sizes.h"
#include "pointreel/chunks.h"
#include "pointreel/draco.h"

namespace pointreel {

Result<PackedFrame> pack_frame(SegmentInput& input, std::size_t index,
                               const std::filesystem::path& file, const Grid* shared,
                               const PackOptions& options, FrameLimits& limits) {
  const Result<SegmentInput::Cloud> loaded = input.take(index);
  if (!loaded) return tl::unexpected(loaded.error());
  PackedFrame frame;
  const PointCloud& cloud = (*loaded)->cloud;
  frame.box = bounds(cloud);
  frame.colors = options.encode.colors && cloud.has_colors();
  frame.normals = options.encode.normals && cloud.has_normals();
  frame.had_radii = cloud.has_radii();
  for (const std::string& warning : (*loaded)->warnings) {
    frame.warnings.push_back(fmt::format("{}: {}", file.string(), warning));
  }
  const Result<Grid> grid = shared != nullptr ? *shared : grid_for(frame.box, options);
  if (!grid) return fail_at(file.string(), grid.error());

  const EncodeOptions encode = limits.of_frame(grid->encode);
  const auto start = std::chrono::steady_clock::now();
  Result<EncodedFrame> encoded = encode_frame(cloud, grid->cube, encode);
  frame.encode_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  if (!encoded) return fail_at(file.string(), encoded.error());
  limits.told(encoded->depth, frame.encode_ms);
  frame.encoded = std::move(*encoded);
  if (!cloud.empty()) frame.max_error = max_geometry_error(grid->cube, frame.encoded.depth);
  const Result<Chunks<std::size_t>> parts =
      measure_part_sizes(frame.encoded, cloud, grid->cube, encode);
  if (!parts) return fail_at(file.string(), parts.error());
  frame.parts = *parts;
  return frame;
}

}  // namespace pointreel
