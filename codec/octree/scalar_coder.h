#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "codec/core/build.h"
#include "codec/octree/frame_structure.h"
#include "pointreel/bytes.h"
#include "pointreel/cloud.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/executor.h"

/// Codes the scalar fields of a tree's leaves. Each field becomes whole numbers, multiples of its
/// step, which are coded like colours that come back exactly (attribute_coder.h). FORMAT.md,
/// "Scalar fields".
namespace pointreel {

/// What the chunk of scalar fields says of one of them, and where its streams are.
struct ScalarStreams {
  std::string name;
  bool labels = false;   ///< values are labels, of which no mean was taken
  bool unknown = false;  ///< some leaves have no value
  double offset = 0.0, step = 1.0;
  std::vector<ByteView> layers;  ///< the streams of the frame's layers, not owned
};

/// The payload of the chunk. Fields without a known value are left out; without any other field, it
/// is empty. The steps are those of OctreeOptions.
Bytes encode_scalars(const FrameStructure& structure, const PointCloud& cloud,
                     const SortedPoints& sorted, std::span<const ScalarStep> steps,
                     const Executor& executor);

/// Takes the payload apart, for a frame with this many layers.
///
/// Trust: the bytes may be hostile. Names, numbers and sizes are checked.
Result<std::vector<ScalarStreams>> parse_scalars(ByteView payload, std::size_t layers);

/// The values of a field, one for each leaf.
///
/// Trust: the bytes may be hostile. Memory depends only on the tree, and values are finite or NaN.
Result<ScalarField> decode_scalar(const FrameStructure& structure, const ScalarStreams& streams);

}  // namespace pointreel
