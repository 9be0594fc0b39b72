#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/chunks.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"
#include "pointreel/executor.h"
#include "pointreel/octree.h"

/// The octree codec, and what frames of every codec have in common. Each encoded frame stands
/// alone: it needs no frame before it. FORMAT.md describes the format byte by byte.
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

/// An encoded frame. Octree frames have up to three layers, base, middle and full, each a prefix's
/// refinement; Draco frames have one.
struct EncodedFrame {
  /// Each chunk has its own header and checksum. `geometry` is never empty; a layer decodes without
  /// its other chunks.
  std::vector<Chunks<Bytes>> layers;
  std::uint32_t source_points = 0;  ///< points given to the encoder
  std::uint32_t coded_points = 0;   ///< points that decoding all layers gives
  int depth = 0;                    ///< octree: level of the leaves; Draco: position bits

  std::size_t size() const {
    std::size_t bytes = 0;
    for (const Chunks<Bytes>& layer : layers) bytes += total(layer);
    return bytes;
  }
};

/// The chunks of encoded layers, which must outlive the views.
std::vector<Chunks<ByteView>> layer_views(std::span<const Chunks<Bytes>> layers);

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

/// Encodes `cloud` within `cube`, as an octree. The bytes depend on the set of points and on
/// nothing else: not on their order, nor on threads, compiler or machine. `normals`, `colors`:
/// whether to encode them where the cloud has them. `executor` lends threads for large frames.
Result<EncodedFrame> encode_octree(const PointCloud& cloud, const Cube& cube,
                                   const OctreeOptions& options = {}, bool normals = true,
                                   bool colors = true, const Executor& executor = {});

/// Decodes a prefix of a frame's layers (at least the first). In each layer, chunks other than the
/// geometry may be empty: the attribute is then that of the layer above, or absent.
///
/// Trust: decoding takes hostile bytes. Memory is bounded before it is taken: by the size of the
/// payload (a zstd payload may expand 1024 times plus 64 KiB, no more), by the header's point count
/// and by DecodeLimits. Masks that are not a tree, sizes that disagree with the masks and counts
/// that disagree with the header are errors. Decoding gives the encoder's voxels exactly, or an
/// error.
Result<DecodedFrame> decode_octree(const std::vector<Chunks<ByteView>>& layers,
                                   const DecodeLimits& limits = {});

/// A package's context tables, from the bytes of its file of tables: DecodeLimits::tables.
///
/// Trust: takes hostile bytes. A file of more than kMaxTableFile bytes is refused, as is one that
/// unpacks to more than 4 MiB or does not hold tables.
Result<std::shared_ptr<const ContextTables>> read_table_file(ByteView file);
inline constexpr std::size_t kMaxTableFile = std::size_t{1} << 20;

/// "octree", "draco", "none", "zstd", "context".
const char* name(Codec codec);
const char* name(Entropy entropy);

}  // namespace pointreel
