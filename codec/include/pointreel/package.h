#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/chunks.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"
#include "pointreel/up.h"

/// A package is a folder of plain files that holds a sequence of frames, a reel, and that any HTTP
/// server can serve: a manifest, `reel.json`, and layer files that never change, one for each layer
/// of each segment. PROTOCOL.md describes it.
namespace pointreel {

inline constexpr int kPackageVersion = 1;
/// The finest level of the octree that video stands on.
inline constexpr int kVideoBaseLevel = 6;
inline constexpr const char* kManifestName = "reel.json";
/// The largest reel.json that readers accept, in bytes.
inline constexpr std::uint64_t kMaxManifestBytes = 32u << 20;
/// The largest file of context tables that readers accept, in bytes.
inline constexpr std::uint64_t kMaxTablesBytes = 1u << 20;

/// The largest file of sound that readers accept, in bytes.
inline constexpr std::uint64_t kMaxAudioBytes = 1u << 30;

/// A file of a package.
struct PackageFile {
  std::string path;            ///< relative to the manifest; letters, digits, '.', '_', '-' only
  std::uint64_t bytes = 0;     ///< the file's size
  std::uint64_t checksum = 0;  ///< `checksum_of` the whole file
};

/// One layer of all frames of a segment: the chunks of one frame after another.
struct LayerFile : PackageFile {
  /// The sizes of each frame's chunks, one entry for each frame of the segment. They add up to
  /// `bytes`.
  std::vector<Chunks<std::uint32_t>> frames;
};

/// Samples of a reel's sound in a second, of each of its two channels.
inline constexpr std::uint32_t kAudioRate = 48'000;

/// The sound of a reel: Opus in Ogg (RFC 7845), one stream from the beginning of the file to its
/// end. Its first sample is heard at time 0. Readers decode it to two channels at kAudioRate.
struct AudioFile : PackageFile {
  std::uint64_t samples = 0;  ///< of each channel, at least 1
};

/// The largest file of a segment's sound that readers accept, in bytes.
inline constexpr std::uint64_t kMaxSegmentSoundBytes = 1u << 20;

/// A group of consecutive frames that share one cube. The cube in a frame's header is
/// authoritative: where each frame has its own, this is a cube that contains them all.
struct Segment {
  std::uint32_t first_frame = 0;
  Cube cube;
  std::vector<std::uint64_t> times_us;  ///< each frame's presentation time from the reel's start
  std::vector<std::uint32_t> points;    ///< each frame's number of points before encoding
  std::vector<LayerFile> layers;        ///< base first; as many as Manifest::layer_names
  /// Of a live stream: the packets of sound that came since the segment before.
  std::optional<PackageFile> sound;

  std::uint32_t frame_count() const { return static_cast<std::uint32_t>(times_us.size()); }
  std::vector<const PackageFile*> files() const;
};

/// For a manifest that grows while its frames are captured. It may hold only the newest frames of a
/// session; they and their times are still counted from 0, so that it is a reel like any other.
struct LiveManifest {
  std::uint64_t session = 0;      ///< a new one means that frame numbers begin again
  std::uint32_t first_frame = 0;  ///< number of frames of the session before the manifest's first
  std::uint64_t start_us = 0;     ///< Unix time of the manifest's time 0, by the publisher's clock
  bool ended = false;             ///< true while no publisher is connected; one may come back
};

/// The lowest and the highest nominal frame rate.
inline constexpr double kMinFps = 1e-6, kMaxFps = 1e6;
inline constexpr bool is_frame_rate(double fps) { return fps >= kMinFps && fps <= kMaxFps; }

/// The values of a scalar field in all frames.
struct ScalarRange {
  std::string name;                ///< of the field
  double least = 0.0, most = 0.0;  ///< finite
  bool labels = false;             ///< a few whole numbers, such as classes

  bool operator==(const ScalarRange&) const = default;
};

/// What reels and live streams have in common, and state before any frame.
struct ReelHead {
  std::string name;     ///< for people
  std::string codec;    ///< "octree", "draco" or "video"
  std::string entropy;  ///< of octrees: "none", "zstd" or "context"; empty for Draco
  /// Of video: the frames of a segment are coded in groups of so many, from its first one on. The
  /// video of a frame needs that of those before it in its group, and nothing else. 0 for other
  /// codecs, whose frames stand alone.
  std::uint32_t group_frames = 0;
  double fps = 30.0;  ///< the nominal frame rate; the times of the frames are authoritative
  Up up = 'y';
  bool colors = false, normals = false;  ///< whether any frame has them
  std::vector<ScalarRange> scalars;      ///< fields that any frame has; at most kMaxScalars
  std::vector<std::string> layer_names;  ///< coarse to fine; scalar fields have one of their own

  bool operator==(const ReelHead&) const = default;
};

/// What was done to the points of a reel before they were encoded: those of noisy scans were moved
/// onto the surface that they are samples of. Lengths are those of the last frame that was cleaned,
/// in the units of the source.
struct Cleaning {
  std::uint32_t frames = 0;   ///< that were cleaned; the others stayed as they were
  std::uint64_t removed = 0;  ///< points that no surface supports
  double spacing = 0.0;       ///< of the points
  double noise = 0.0;         ///< root mean square distance from the surface
  double radius = 0.0;        ///< in which the surface was fitted

  bool operator==(const Cleaning&) const = default;
};

/// How far decoded frames are from those that were encoded, cleaned if they were: means over a few
/// frames, each the worse of both directions (codec/distance/distance.h).
struct CodingError {
  std::uint32_t frames = 0;    ///< that were compared
  double d1 = 0.0;             ///< mean squared distance to the nearest point, in squared units
  std::optional<double> d2;    ///< the same along the normals there
  std::optional<double> luma;  ///< mean squared difference, in squared 8-bit steps

  bool operator==(const CodingError&) const = default;
};

/// The content of reel.json.
struct Manifest : ReelHead {
  std::uint64_t duration_us = 0;  ///< of one pass, including the last frame's own duration
  /// Unix time of time 0, by the clock of the program that captured it. Absent if that is not
  /// known.
  std::optional<std::uint64_t> captured_us;
  std::uint32_t depth_min = 0, depth_max = 0;
  Box bounds;  ///< of all frames; empty if no frame has a point
  /// How far a point, cleaned if it was, can be from its decoded position, in the units of the
  /// source, as the packer measured it. Absent if nobody did.
  std::optional<double> max_error;
  std::optional<CodingError> coding_error;  ///< absent if nobody measured it
  std::optional<Cleaning> cleaning;         ///< absent if no frame was cleaned
  std::optional<PackageFile> tables;  ///< the reel's own context tables, if its frames need any
  std::optional<AudioFile> audio;     ///< absent if the reel is silent
  std::optional<LiveManifest> live;   ///< only while frames may still be added
  /// Some frames have fewer layers than their headers say, because a live link did not carry all of
  /// them. Such frames are coarser, not damaged.
  bool partial = false;
  /// Normals, of some frames at least, were estimated from the points, and may point to either side
  /// of the surface.
  bool normals_estimated = false;
  std::vector<Segment> segments;

  std::uint32_t frame_count() const;
  /// All files that the manifest names: tables, sound, then those of each segment.
  std::vector<const PackageFile*> files() const;
};

/// The place of a frame in a manifest.
struct FrameLocation {
  std::uint32_t segment = 0;  ///< index into Manifest::segments
  std::uint32_t index = 0;    ///< the frame's index within its segment
};
/// `frame` < manifest.frame_count().
FrameLocation locate(const Manifest& manifest, std::uint32_t frame);

/// Frames of a reel that are decoded one after another.
struct FrameGroup {
  std::uint32_t first = 0, frames = 1;
};
/// The group of a frame, < manifest.frame_count(). Only video has groups of several frames.
FrameGroup group_of(const Manifest& manifest, std::uint32_t frame);

struct ByteRange {
  std::uint64_t offset = 0, size = 0;
};
/// Where the chunks of a segment's frame `index` are in a layer's file. They follow each other:
/// geometry, colours, normals, with the sizes file.frames[index].
ByteRange byte_range(const LayerFile& file, std::uint32_t index);

/// A frame's presentation time. `frame` < manifest.frame_count().
std::uint64_t frame_time_us(const Manifest& manifest, std::uint32_t frame);
/// All frames in order, except frames of video with no duration: in a cut, these only serve to
/// decode the ones after them.
std::vector<std::uint32_t> shown_frames(const Manifest& manifest);
/// The frame to show at a time: the last one whose own time is not later, or the first frame if
/// there is none. The manifest has at least one frame.
std::uint32_t frame_at(const Manifest& manifest, std::uint64_t time_us);

/// Parses the text of a reel.json. Unknown keys are ignored. The error names the place, as in
/// `segments[2].files[0].bytes: ...`.
///
/// Errors: `unsupported` for a newer format version, `limit` for more than kMaxManifestBytes,
/// otherwise `invalid`.
///
/// Trust: the text may be hostile. Every count, size, name and number is checked: sizes agree with
/// their sums, frames are consecutive, times do not decrease, numbers are finite, each path is used
/// once and stays in the folder, and no object has a key twice. Memory is bounded by about 50 bytes
/// for each byte of the text.
Result<Manifest> parse_manifest(std::string_view text);

}  // namespace pointreel
