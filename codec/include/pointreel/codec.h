#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/chunks.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"
#include "pointreel/executor.h"
#include "pointreel/octree.h"

/// The octree codec, and what it shares with the Draco codec (draco.h). Every encoded frame stands
/// alone: decoding it needs no other frame. FORMAT.md describes the format byte by byte.
///
/// No function that returns a Result throws. If there is not enough memory, it returns the error
/// `limit`, and nothing is leaked. Where the codec is compiled without exceptions (CMake's
/// POINTREEL_EXCEPTIONS=OFF), a lack of memory ends the program; DecodeLimits::max_memory then
/// keeps frames below what there is.
namespace pointreel {

/// Trained probability tables for Entropy::context. read_table_file reads them.
struct ContextTables;

/// `video`: layered depth video on top of an octree of few levels. It exists in packages, not as
/// frames that stand alone.
enum class Codec : std::uint8_t { octree = 1, draco = 2, video = 3 };

/// How the octree codec compresses geometry: not at all, with zstd, or with trained contexts, which
/// give by far the smallest frames.
enum class Entropy : std::uint8_t { none = 0, zstd = 1, context = 2 };

/// A quality at which errors of colour do not show even where dark colours are seen from nearby:
/// luma at about 45 dB on a dense scan of a person.
inline constexpr int kDefaultColorQuality = 64;
inline constexpr int kLosslessColorQuality = 100;
/// A quality at which normals are off by about one degree on a dense scan, two on a sparse one.
inline constexpr int kDefaultNormalQuality = 43;
inline constexpr int kBestNormalQuality = 100;

/// No step of a scalar field is smaller than its range divided by this.
inline constexpr double kMostScalarSteps = 32'767.0;

/// How finely a scalar field is coded.
struct ScalarStep {
  std::string name;   ///< of the field
  double step = 1.0;  ///< above 0 and finite; decoded values are off by up to half of it
};

struct OctreeOptions {
  Entropy entropy = Entropy::context;
  DepthRule depth;
  /// 1 to 100. Below 100, colours are transformed and quantised in steps of
  /// 2^((99 - quality) / 14), in units of 8-bit colour values: every +14 halves the step. Colours
  /// of 16 bits then keep at most 14 of them. At 100, colours are lossless.
  int color_quality = kDefaultColorQuality;
  /// The same for normals, in units of 1/127.5 of their length. At 100, normals are not transformed
  /// but rounded to half a degree.
  int normal_quality = kDefaultNormalQuality;
  /// Quantise normals in coarser steps where they are noisy, down to 2.5 times the standard
  /// deviation of their noise, which would otherwise take most of the bits.
  bool normals_follow_noise = true;
  /// For Entropy::context: tables that were trained for the sequence; null for the newest that are
  /// built into the codec. A frame names its tables by their checksum, and the decoder must be
  /// given the same ones (DecodeLimits::tables).
  std::shared_ptr<const ContextTables> tables = nullptr;
  /// For Entropy::context: the number of slabs of a frame that are coded in parallel, 1 to 16; 0
  /// chooses it by the number of leaves. Each additional slab adds about one percent to the size of
  /// a dense frame.
  int slabs = 0;
  /// Whether to encode scalar fields where the cloud has them.
  bool scalars = true;
  /// The steps of fields. Those that are not listed are kept exactly if all their values are whole
  /// numbers that span no more than 255; otherwise their step is 1/255 of the range that holds all
  /// values but the 1/1000 at either end. See kMostScalarSteps.
  std::vector<ScalarStep> scalar_steps = {};
};

/// An encoded frame. Octree frames have up to three layers, from coarse to fine: any number of them
/// from the first on decodes. Draco frames have a single layer.
struct EncodedFrame {
  /// Each chunk has its own header and checksum. `geometry` is never empty; a layer also decodes
  /// without its other chunks. An octree frame with scalar fields has one layer more than it takes
  /// to reach its leaves. That layer holds the fields, in place of a geometry.
  std::vector<Chunks<Bytes>> layers;
  std::uint32_t source_points = 0;  ///< the number of points that the encoder was given
  std::uint32_t coded_points = 0;   ///< the number of points that all layers decode to
  int depth = 0;                    ///< octree: level of the leaves; Draco: bits of a position
  bool has_scalars = false;         ///< the last layer holds scalar fields

  /// The size of the scalar fields, in bytes.
  std::size_t scalar_bytes() const { return has_scalars ? layers.back().geometry.size() : 0; }
  /// The size of all chunks, in bytes.
  std::size_t size() const {
    std::size_t bytes = 0;
    for (const Chunks<Bytes>& layer : layers) bytes += total(layer);
    return bytes;
  }
};

/// Views of the chunks of encoded layers, which must outlive them.
std::vector<Chunks<ByteView>> layer_views(std::span<const Chunks<Bytes>> layers);

/// The default of DecodeLimits::max_memory, in bytes. It suffices for about 10 million points.
inline constexpr std::uint64_t kFrameMemory = std::uint64_t{1} << 30;

/// What decoding may use and produce, however large the numbers in the frame are.
struct DecodeLimits {
  std::uint32_t max_points = 1u << 26;  ///< a frame with more points is refused: ErrorCode::limit
  /// A frame that takes more memory to decode, in bytes, is refused before that memory is
  /// allocated: ErrorCode::limit. What counts are the frame's points, nodes and attributes, in
  /// upper bounds; the time that decoding takes grows with the same numbers. In addition, decoding
  /// takes a few MiB for tables.
  std::uint64_t max_memory = kFrameMemory;
  /// The sequence's own context tables, if it has any. They must outlive the call.
  const ContextTables* tables = nullptr;
  Executor executor = {};  ///< decodes slabs, and colours and normals, in parallel
  /// Octree: asked before each chunk, possibly by several threads at once. From the first yes on,
  /// decoding fails with ErrorCode::cancelled. Empty: never.
  std::function<bool()> stopped = {};
  /// Octree: whether to produce the attributes of all nodes (DecodedFrame::attributes).
  bool inner_nodes = false;
  /// Octree: whether to produce the leaves as a cloud. Without them, decoding makes only the tree
  /// and, with `inner_nodes`, the attributes of its nodes.
  bool leaves = true;
  /// Octree, only without `leaves`: cuts the tree off at this level. Transformed attributes are not
  /// decoded any further, so damage in the rest of them goes unnoticed.
  int depth = kMaxDepth;
  /// Octree, only without `leaves`: the same for transformed normals alone. Nodes below this level
  /// have the normals of their ancestors. Normals take as long to decode as the tree, and those of
  /// the finest level change little where its nodes are small.
  int normals_depth = kMaxDepth;
  /// Video: points may be as far apart as this, in world units, where a view shows no more. 0: all
  /// that the frame has.
  double spacing = 0.0;
  /// Octree: whether to decode scalar fields. They need all layers, and no lower `depth`.
  bool scalars = true;
  /// Octree: if not empty, the name of the only scalar field to decode.
  std::string scalar = {};
};

struct DecodedFrame {
  PointCloud cloud;        ///< octree: the centres of the leaves, in the order of the leaves
  std::optional<Svo> svo;  ///< octree only: the tree whose leaves `cloud` holds
  /// The attributes of all nodes of that tree, if DecodeLimits::inner_nodes asks for them. For
  /// transformed attributes these are the decoded values, which are close to the means of the
  /// leaves; for others they are the means.
  NodeAttributes attributes;
  /// Without DecodeLimits::leaves, the scalar fields of the tree's leaves.
  std::vector<ScalarField> scalars;
  Cube cube;
  int depth = 0;  ///< octree: level of the leaves of the whole frame, however much was decoded
  /// The number of points that the encoder was given; of video, those that the frame has.
  std::uint32_t source_points = 0;
  /// Video: the points have radii, and lie as far apart as DecodeLimits::spacing allows.
  bool spaced = false;
};

/// Encodes `cloud` as an octree of `cube`; points outside the cube move to its faces. The bytes
/// depend on the set of points only: not on their order, the executor, the compiler or the machine.
/// `normals` and `colors` say whether to encode these where the cloud has them.
///
/// A leaf has the mean of its points' values of a scalar field, rounded to the field's step. Fields
/// of up to 32 different whole numbers that span no more than 255, such as classes, are labels: a
/// leaf has the label of most of its points.
///
/// Errors: `argument` if an option, the cube or a scalar field (cloud.h) is out of range, `limit`
/// from 2^31 points on.
Result<EncodedFrame> encode_octree(const PointCloud& cloud, const Cube& cube,
                                   const OctreeOptions& options = {}, bool normals = true,
                                   bool colors = true, const Executor& executor = {});

/// Decodes the first layers of a frame, one or more. In each layer, all chunks but the geometry may
/// be empty: the points then have the attribute of the layer before, or do not have it at all.
///
/// Errors: `invalid` if the bytes are damaged, `unsupported` if they need a newer version of the
/// codec, `limit` if the frame exceeds `limits`, `not_found` if it needs tables that were not
/// given, `cancelled` if `limits.stopped` says so.
///
/// Trust: the bytes may be hostile. The memory that decoding takes is bounded beforehand by
/// DecodeLimits::max_memory, by the size of the payload (a byte pays for 1024 masks of the octree,
/// and 64 Ki masks are free), and by the number of points in the header. Masks that do not form a
/// tree, sizes that disagree with the masks, and counts that disagree with the header are errors.
/// The result is exactly the encoder's voxels, or an error.
Result<DecodedFrame> decode_octree(const std::vector<Chunks<ByteView>>& layers,
                                   const DecodeLimits& limits = {});

/// Reads a package's file of context tables (Manifest::tables in package.h), for
/// DecodeLimits::tables and OctreeOptions::tables.
///
/// Trust: the bytes may be hostile. A file of more than kMaxTablesBytes (package.h) is refused, and
/// so is one that unpacks to more than 4 MiB.
Result<std::shared_ptr<const ContextTables>> read_table_file(ByteView file);

/// "octree", "draco", "video", "none", "zstd", "context".
const char* name(Codec codec);
const char* name(Entropy entropy);

}  // namespace pointreel
