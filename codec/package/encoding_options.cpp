#include "codec/package/encoding_options.h"

#include <fmt/format.h>

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

std::string why_not_cleaned(const CleanOptions& options,
                            const std::map<NotCleaned, std::uint32_t>& frames) {
  const auto phrase = [&](NotCleaned why) {
    switch (why) {
      case NotCleaned::few_points:
        return "have too few points";
      case NotCleaned::no_normals:
        return "have no normals (--clean auto cleans them nevertheless)";
      case NotCleaned::voxelised:
        return "are voxelised";
      case NotCleaned::smooth:
        return "are smooth";
      case NotCleaned::repeated:
        return "repeat points";
      case NotCleaned::no_surface:
        return options.radius ? "have too few points with a surface within that radius"
                              : "are no scans of surfaces";
    }
    return "";
  };
  if (options.radius && frames.contains(NotCleaned::no_surface) && frames.size() == 1)
    return "around most points, no surface fits within that radius; try auto";
  if (frames.size() == 1) return fmt::format("the frames {}", phrase(frames.begin()->first));
  std::string text;
  for (const auto& [why, count] : frames)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, phrase(why));
  return text;
}

}  // namespace pointreel
