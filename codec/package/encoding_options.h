#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "codec/core/placement.h"
#include "codec/surface/clean_in_time.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "pointreel/package.h"

namespace pointreel {

inline constexpr std::size_t kMostCleanFrames = 4;

/// What becomes of frames that have no normals: players derive them, or they are estimated and
/// encoded.
enum class MissingNormals { derived, estimated, estimated_if_it_pays };

/// What pack and publish are both told about a sequence of frames, and how to encode it.
struct EncodingOptions {
  std::string name;   ///< for people
  double fps = 30.0;  ///< nominal frames per second, kMinFps to kMaxFps
  Up up = 'y';
  /// How the frames of files are placed, before anything else is done with them.
  Placement placement;
  EncodeOptions encode;
  /// Of octrees, with EncodeOptions::normals. Of live streams, `derived`.
  MissingNormals missing_normals = MissingNormals::derived;
  /// Edge of a voxel in the source's units. Voxels are centred on multiples of it, or on the voxels
  /// of the source that they merge. It determines the depth of the octree.
  std::optional<double> voxel;
  /// How frames are cleaned before they are encoded. Nothing: they stay as they are, and so they
  /// do with `voxel` unless a radius is given or `resample` is set.
  std::optional<CleanOptions> clean;
  /// So many frames on either side in time help to clean each frame, up to kMostCleanFrames; of
  /// live streams, those before it.
  std::size_t clean_frames = 0;
  /// The voxels are not those of the source but sample its surface anew, after it was cleaned.
  bool resample = false;
  /// The octrees of cleaned frames have cells that fit their points, instead of DepthRule's delta.
  bool cells_fit_cleaned = true;
  /// Milliseconds, above 0, that encoding a frame may take. FrameTimeControl lowers the depth to
  /// achieve this, so the encoded bytes depend on the machine.
  std::optional<double> frame_time_ms;
  int threads = 0;  ///< that encode; 0: one for each processor
  /// DecodeLimits::max_memory of each frame that is read from files.
  std::uint64_t max_memory = kFrameMemory;
};

/// What a reel or a live stream of such frames says about itself. Colours, normals and scalar
/// fields are not known before there is a frame.
ReelHead reel_head(const EncodingOptions& options);

/// Lines for people, for clouds that have scalar fields.
inline constexpr const char* kNoScalarsInDraco =
    "scalar fields, such as intensities, are left out: Draco frames have none; use --codec octree";
inline constexpr const char* kNoScalarsInVideo =
    "scalar fields, such as intensities, are left out: video has none; use --codec octree";

/// How frames are cleaned; null if they are not.
const CleanOptions* cleaning_of(const EncodingOptions& options);
/// Cleans a frame as the options say, by itself. A frame without normals gets none, since players
/// derive them from the cleaned points as well.
CleanReport clean_frame(PointCloud& cloud, const EncodingOptions& options);
/// The same for a frame that `clean_alone` has cleaned, with those around it in time.
CleanedInTime clean_frame(const CleanedFrame& alone, std::span<const CleanedFrame* const> around,
                          const EncodingOptions& options);
/// Why frames were not cleaned, for people: how many, for each reason.
std::string why_not_cleaned(const CleanOptions& options,
                            const std::map<NotCleaned, std::uint32_t>& frames);

}  // namespace pointreel
