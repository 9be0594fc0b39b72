#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/chunks.h"
#include "pointreel/cloud.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/executor.h"

/// The Draco codec, and encoding and decoding with whichever codec a frame has. Link
/// pointreel::draco.
namespace pointreel {

/// The order in which Draco codes points: one after another along the Morton curve, or as a
/// kd-tree. `automatic` chooses as draco_encoder does: sequential at level 0, otherwise the
/// kd-tree.
enum class DracoMethod : std::uint8_t { automatic, sequential, kd_tree };

/// Names and defaults of draco_encoder.
struct DracoOptions {
  int position_bits = 11;     ///< --qp, 1 to 21, relative to the edge of the cube
  int normal_bits = 8;        ///< --qn, 2 to 16
  int generic_bits = 8;       ///< --qg; Pointreel has no generic attribute today
  int compression_level = 7;  ///< --cl, 0 (fastest) to 10 (smallest)
  DracoMethod method = DracoMethod::automatic;
};

/// The codec, with its options, and what applies to every codec.
struct EncodeOptions {
  std::variant<OctreeOptions, DracoOptions> codec;
  bool normals = true;     ///< encode normals where the cloud has them
  bool colors = true;      ///< encode colours where the cloud has them
  Executor executor = {};  ///< lends threads for large frames; no byte depends on it

  Codec id() const { return codec.index() == 0 ? Codec::octree : Codec::draco; }
};

/// Encodes with the codec that the options name: as encode_octree, or with Draco as a frame of one
/// layer, whose geometry chunk holds all attributes.
Result<EncodedFrame> encode_frame(const PointCloud& cloud, const Cube& cube,
                                  const EncodeOptions& options);

/// Decodes a frame of either codec, by its header: as decode_octree, or, for Draco, into points in
/// no particular order, duplicates included, without a tree.
///
/// Trust: takes hostile bytes. Headers and checksums are checked first; Draco is given no payload
/// whose counts its bytes cannot pay for.
Result<DecodedFrame> decode_frame(const std::vector<Chunks<ByteView>>& layers,
                                  const DecodeLimits& limits = {});

}  // namespace pointreel
