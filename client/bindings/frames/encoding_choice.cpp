#include "client/bindings/frames/encoding_choice.h"

#include <cmath>

#include "common/base/concat.h"
#include "common/base/try.h"
#include "pointreel/draco.h"

namespace pointreel {
namespace {

Result<void> check_range(int value, int most, const char* what) {
  if (value >= 0 && value <= most) return {};
  return fail(ErrorCode::argument, concat(what, " is ", value, ", not 1 to ", most));
}

Result<EncodingOptions> draco_of(const EncodingChoice& choice) {
  if (choice.voxel != 0.0 || choice.delta != 0.0 || choice.color_quality != 0 ||
      choice.normal_quality != 0 || choice.fast || !choice.scalar_steps.empty())
    return fail(ErrorCode::argument,
                "Draco has no voxels, delta, qualities, fast frames or scalar fields");
  DracoOptions draco;
  if (choice.depth != 0) draco.position_bits = choice.depth;
  EncodingOptions options;
  options.encode.codec = draco;
  return options;
}

}  // namespace

Result<EncodingOptions> encoding_of(const EncodingChoice& choice) {
  TRY(check_range(choice.depth, kMaxDepth, "depth"));
  TRY(check_range(choice.color_quality, kLosslessColorQuality, "color_quality"));
  TRY(check_range(choice.normal_quality, kBestNormalQuality, "normal_quality"));
  if (choice.codec == Codec::draco) return draco_of(choice);
  if (choice.codec == Codec::video &&
      (choice.depth != 0 || choice.voxel != 0.0 || choice.delta != 0.0 ||
       choice.normal_quality != 0 || choice.fast || !choice.scalar_steps.empty()))
    return fail(ErrorCode::argument,
                "video has no depth, voxels, delta, normal_quality, fast frames or scalar fields");
  OctreeOptions octree;
  if (choice.depth != 0) octree.depth = DepthRule::fixed(choice.depth);
  if (choice.delta != 0.0) {
    if (!(choice.delta > 0.0 && choice.delta < 1.0))
      return fail(ErrorCode::argument, "delta is not a share between 0 and 1");
    if (choice.depth != 0 || choice.voxel != 0.0)
      return fail(ErrorCode::argument, "delta excludes depth and voxel");
    octree.depth = DepthRule::by_delta(choice.delta);
  }
  for (const auto& [name, step] : choice.scalar_steps) {
    if (!is_scalar_name(name) || !(step > 0.0 && std::isfinite(step)))
      return fail(ErrorCode::argument, "scalar_steps are steps above 0, by the names of fields");
  }
  octree.scalar_steps = choice.scalar_steps;
  if (choice.color_quality != 0) octree.color_quality = choice.color_quality;
  if (choice.normal_quality != 0) {
    octree.normal_quality = choice.normal_quality;
    octree.normals_follow_noise = false;
  }
  if (choice.fast) octree.entropy = Entropy::zstd;
  EncodingOptions options;
  options.encode.codec = octree;
  if (choice.voxel != 0.0) {
    if (!(choice.voxel > 0.0) || !std::isfinite(choice.voxel))
      return fail(ErrorCode::argument, "voxel is not a length above 0");
    if (choice.depth != 0) return fail(ErrorCode::argument, "voxel and depth exclude each other");
    options.voxel = choice.voxel;
  }
  return options;
}

}  // namespace pointreel
