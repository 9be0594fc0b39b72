#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/base/executor.h"
#include "common/cloud/point_cloud.h"
#include "common/octree/svo.h"

/// Bytes <-> frames. Every encoded frame stands alone: it needs no frame before it. Formats are
/// described byte by byte in FORMAT.md.
namespace pointreel {

/// Trained tables of Entropy::context: codec/octree/context_model.h.
struct ContextTables;

enum class Codec : std::uint8_t { octree = 1, draco = 2 };
enum class Entropy : std::uint8_t { none = 0, zstd = 1, context = 2 };

/// A quality of colours whose error is seen on a second look: luma at about 41 dB on a dense human.
inline constexpr int kDefaultColorQuality = 50;
inline constexpr int kLosslessColorQuality = 100;
/// A quality of normals of about one degree on a dense human, two on a sparse one.
inline constexpr int kDefaultNormalQuality = 43;
inline constexpr int kBestNormalQuality = 100;

struct OctreeOptions {
  Entropy entropy = Entropy::context;
  DepthRule depth;
  /// 1 to 100. Below 100 colours are transformed and quantised by 2^((99 - quality) / 14) 8-bit
  /// steps: 14 more halve the step (QUALITY.md: dB and bits of each). Colours of 16 bits keep 14.
  /// 100 keeps them as they are.
  int color_quality = kDefaultColorQuality;
  /// The same of normals, a step being 1/127.5 of their length. At 100 they are rounded to half a
  /// degree.
  int normal_quality = kDefaultNormalQuality;
  /// Of entropy context; null: the newest that are part of the codec. Given ones have a checksum,
  /// and whoever decodes must be given the same.
  std::shared_ptr<const ContextTables> tables = nullptr;
  /// Of entropy context: parts of a frame that are coded at the same time, 1 to 16 along the longer
  /// of y and z; each adds about one percent to a dense frame. 0: chosen from the number of leaves.
  int slabs = 0;
};

/// In which order Draco codes points: one after another along the Morton curve, or as a kd-tree.
/// `automatic` is draco_encoder's choice: sequential at level 0, else the kd-tree.
enum class DracoMethod : std::uint8_t { automatic, sequential, kd_tree };

/// Names and defaults of draco_encoder.
struct DracoOptions {
  int position_bits = 11;     ///< --qp, 1 to 21, relative to the edge of the cube
  int normal_bits = 8;        ///< --qn, 2 to 16
  int generic_bits = 8;       ///< --qg; no attribute of ours is generic today
  int compression_level = 7;  ///< --cl, 0 (fastest) to 10 (smallest)
  DracoMethod method = DracoMethod::automatic;
};

struct EncodeOptions {
  std::variant<OctreeOptions, DracoOptions> codec;
  bool normals = true;     ///< encode normals where the cloud has them
  bool colors = true;      ///< encode colours where the cloud has them
  Executor executor = {};  ///< lends threads for large frames; no byte depends on it

  Codec id() const { return codec.index() == 0 ? Codec::octree : Codec::draco; }
};

/// One layer of a frame: up to three chunks, each with its own header and checksum, in the order in
/// which a package stores them. `geometry` is never empty; without the others it still decodes.
struct EncodedLayer {
  Bytes geometry, colors, normals;

  std::size_t size() const { return geometry.size() + colors.size() + normals.size(); }
};

/// An encoded frame. Octree frames have up to three layers, base, middle and full, each a prefix's
/// refinement; Draco frames have one.
struct EncodedFrame {
  std::vector<EncodedLayer> layers;
  std::uint32_t source_points = 0;  ///< points given to the encoder
  std::uint32_t coded_points = 0;   ///< points that decoding all layers gives
  int depth = 0;                    ///< octree: level of the leaves; Draco: position bits

  std::size_t size() const {
    std::size_t bytes = 0;
    for (const EncodedLayer& layer : layers) bytes += layer.size();
    return bytes;
  }
};

/// The chunks of one layer as they came from a file or a peer; empty where they were not fetched.
struct LayerView {
  ByteView geometry, colors, normals;
};

/// The chunks of encoded layers, which must outlive the views.
std::vector<LayerView> layer_views(std::span<const EncodedLayer> layers);

/// Bounds on what a decoder may be made to produce, whatever the bytes claim, and what it may use.
struct DecodeLimits {
  std::uint32_t max_points = 1u << 26;
  /// The context tables that come with the frames, if any do; they outlive the call.
  const ContextTables* tables = nullptr;
  Executor executor = {};  ///< lends threads for slabs, and for colours beside normals
  /// Octree: also gives the attributes of all nodes.
  bool inner_nodes = false;
  /// Octree: gives the leaves as a cloud. Without it, and with `inner_nodes`, there is the tree
  /// with its nodes' attributes alone, and nothing is made that is only in the cloud.
  bool leaves = true;
  /// Octree, without `leaves`: cuts the tree off at this level. Attributes that the encoder
  /// transformed are not decoded any further, and what is wrong with the rest is not found out.
  int depth = kMaxDepth;
};

struct DecodedFrame {
  PointCloud cloud;        ///< octree: centres of the leaves, in the order of the leaves
  std::optional<Svo> svo;  ///< octree only: the tree whose leaves `cloud` holds
  /// Of all nodes of that tree, if DecodeLimits asks for them: what came out of decoding where the
  /// encoder transformed them, which is nearly mean_attributes, else mean_attributes.
  NodeAttributes attributes;
  Cube cube;
  int depth = 0;  ///< octree: level of the leaves of the whole frame, however much was decoded
  std::uint32_t source_points = 0;  ///< what the delta criterion refers to
};

/// Encodes `cloud` within `cube`. The bytes depend on the set of points and on nothing else: not on
/// their order, nor on threads, compiler or machine.
Result<EncodedFrame> encode_frame(const PointCloud& cloud, const Cube& cube,
                                  const EncodeOptions& options);

/// Bytes that each part of an encoded frame takes, headers included; their sum is frame.size().
struct PartSizes {
  std::size_t geometry = 0, colors = 0, normals = 0;
};

/// Octree chunks are counted. Draco interleaves attributes, so there the parts are measured by
/// encoding the cloud again without them: as slow as two more encodes.
Result<PartSizes> measure_parts(const EncodedFrame& frame, const PointCloud& cloud,
                                const Cube& cube, const EncodeOptions& options);

/// Decodes a prefix of a frame's layers (at least the first). Trusts nothing: see each codec's
/// header.
Result<DecodedFrame> decode_frame(const std::vector<LayerView>& layers,
                                  const DecodeLimits& limits = {});

/// "octree", "draco", "none", "zstd", "context".
const char* name(Codec codec);
const char* name(Entropy entropy);

}  // namespace pointreel
