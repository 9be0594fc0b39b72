#pragma once

#include <vector>

#include "codec/package/encoding_options.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"

namespace pointreel {

/// How to encode, as other languages choose it: each member has its own default for 0.
struct EncodingChoice {
  Codec codec = Codec::octree;
  int depth = 0;           ///< octree: levels, 0: by the points; Draco: bits
  double voxel = 0.0;      ///< octree: edge of a voxel; 0: by `depth`
  double delta = 0.0;      ///< octree without `depth` and `voxel`: DepthRule::delta
  int color_quality = 0;   ///< octree, and video with its depth: 1 to 100
  int normal_quality = 0;  ///< octree: 1 to 100
  bool fast = false;       ///< octree: Entropy::zstd
  std::vector<ScalarStep> scalar_steps = {};  ///< octree
};

/// Of video, the options are those of octrees. Errors: `argument` for what is out of range, or does
/// not go together.
Result<EncodingOptions> encoding_of(const EncodingChoice& choice);

}  // namespace pointreel
