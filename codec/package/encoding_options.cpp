#include "codec/package/encoding_options.h"

namespace pointreel {

ReelHead reel_head(const EncodingOptions& options) {
  ReelHead head;
  head.name = options.name;
  head.codec = name(options.encode.id());
  head.fps = options.fps;
  head.up = options.up;
  if (const auto* octree = std::get_if<OctreeOptions>(&options.encode.codec)) {
    head.entropy = name(octree->entropy);
    head.layer_names = {"base", "middle", "full"};
  } else {
    head.layer_names = {"full"};
  }
  return head;
}

const CleanOptions* cleaning_of(const EncodingOptions& options) {
  if (!options.clean || (options.voxel && !options.resample && !options.clean->radius))
    return nullptr;
  return &*options.clean;
}

CleanReport clean_frame(PointCloud& cloud, const EncodingOptions& options) {
  const CleanOptions* cleaning = cleaning_of(options);
  if (cleaning == nullptr) return {};
  const bool had_normals = cloud.has_normals();
  CleanReport report = clean(cloud, *cleaning, options.encode.executor);
  if (!had_normals) cloud.normals.clear();
  return report;
}

CleanedInTime clean_frame(const CleanedFrame& alone, std::span<const CleanedFrame* const> around,
                          const EncodingOptions& options) {
  auto in_time = clean_in_time(alone, around, *cleaning_of(options), options.encode.executor);
  CleanedInTime out = in_time ? *std::move(in_time) : CleanedInTime{alone.cloud, alone.report};
  if (!alone.had_normals) out.cloud.normals.clear();
  return out;
}

std::string_view why_not_cleaned(const CleanOptions& options) {
  if (options.radius) return "around most points, no surface fits within that radius; try auto";
  if (!options.without_normals)
    return "the frames are smooth, voxelised, without normals, or no scans of surfaces";
  return "the frames are smooth, voxelised, or no scans of surfaces";
}

}  // namespace pointreel
