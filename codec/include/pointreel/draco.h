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

/// The Draco codec, and functions that encode and decode frames of either codec. Link
/// pointreel::draco.
namespace pointreel {

/// The order in which Draco codes points: along the Morton curve, or as a kd-tree. `automatic`
/// chooses as draco_encoder does: sequential at compression level 0, otherwise the kd-tree.
enum class DracoMethod : std::uint8_t { automatic, sequential, kd_tree };

inline constexpr int kMinNormalBits = 2, kMaxNormalBits = 16, kMaxCompressionLevel = 10;

/// The options of draco_encoder, with its defaults.
struct DracoOptions {
  /// --qp, 1 to kMaxDepth: divides the edge of the cube into 2^bits cells.
  int position_bits = 11;
  int normal_bits = 8;        ///< --qn, kMinNormalBits to kMaxNormalBits
  int compression_level = 7;  ///< --cl, 0 (fastest) to kMaxCompressionLevel (smallest)
  DracoMethod method = DracoMethod::automatic;
};

/// Which codec to encode with, its options, and the options that apply to both codecs.
struct EncodeOptions {
  std::variant<OctreeOptions, DracoOptions> codec;
  bool normals = true;     ///< whether to encode normals where the cloud has them
  bool colors = true;      ///< whether to encode colours where the cloud has them
  Executor executor = {};  ///< speeds up large frames; the bytes do not depend on it

  Codec id() const { return codec.index() == 0 ? Codec::octree : Codec::draco; }
};

/// Encodes with the codec that the options name: like encode_octree, or with Draco, as a frame with
/// a single layer whose geometry chunk holds all attributes.
///
/// Errors: `argument` if an option or the cube is out of range, `limit` if there are too many
/// points (2^31 for octrees, 2^26 for Draco).
Result<EncodedFrame> encode_frame(const PointCloud& cloud, const Cube& cube,
                                  const EncodeOptions& options);

/// Decodes a frame of either codec, which its header names: like decode_octree, or with Draco, into
/// points in no particular order, duplicates included, and without a tree.
///
/// Errors: as decode_octree.
///
/// Trust: the bytes may be hostile. Headers and checksums are checked first. Draco is given no
/// payload that declares more points than its size can justify, and is stopped before it takes more
/// memory than DecodeLimits::max_memory.
Result<DecodedFrame> decode_frame(const std::vector<Chunks<ByteView>>& layers,
                                  const DecodeLimits& limits = {});

}  // namespace pointreel
