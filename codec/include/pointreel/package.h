#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/chunks.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"

/// A package is a folder of plain files that any HTTP server can serve: `reel.json` and immutable
/// segment files, one for each layer of each segment. PROTOCOL.md beside this file describes it.
namespace pointreel {

inline constexpr int kPackageVersion = 1;
inline constexpr const char* kManifestName = "reel.json";
/// A longer reel.json is refused before it is read, from a disk or from a server.
inline constexpr std::uint64_t kMaxManifestBytes = 32u << 20;

/// One immutable file of a package.
struct PackageFile {
  std::string path;            ///< relative to the manifest; letters, digits, '.', '_', '-' only
  std::uint64_t bytes = 0;     ///< the file's size
  std::uint64_t checksum = 0;  ///< `checksum_of` the whole file
};

/// The chunks of one layer of all frames of a segment, frame after frame.
struct LayerFile : PackageFile {
  /// The sizes of each frame's chunks, one entry for each frame of the segment; their sum is
  /// `bytes`.
  std::vector<Chunks<std::uint32_t>> frames;
};

/// A group of consecutive frames that share one cube (with --cube frame: the bounds' cube; each
/// frame's header holds its own).
struct Segment {
  std::uint32_t first_frame = 0;
  Cube cube;
  std::vector<std::uint64_t> times_us;  ///< presentation time of each frame from the reel's start
  std::vector<std::uint32_t> points;    ///< source points of each frame
  std::vector<LayerFile> layers;        ///< base first; as many as Manifest::layer_names

  std::uint32_t frame_count() const { return static_cast<std::uint32_t>(times_us.size()); }
};

/// Of a manifest that grows while its frames are captured, and may hold the newest of them only.
/// Frames and times within it count from 0 all the same, so that it is a reel like any other.
struct LiveManifest {
  std::uint64_t session = 0;      ///< as in LiveHello (live.h)
  std::uint32_t first_frame = 0;  ///< frames of the session that came before those in the manifest
  std::uint64_t start_us = 0;     ///< Unix time of the manifest's time 0, by the publisher's clock
  bool ended = false;             ///< the publisher has gone; it may come back
};

/// What reels and live streams say of themselves before any frame.
struct ReelHead {
  std::string name;     ///< for people
  std::string codec;    ///< "octree" or "draco"
  std::string entropy;  ///< "none", "zstd" or "context"; empty for Draco
  double fps = 30.0;    ///< nominal rate; frames' times rule
  char up = 'y';        ///< 'y' or 'z'
  bool colors = false, normals = false;
  std::vector<std::string> layer_names;  ///< coarse to fine

  bool operator==(const ReelHead&) const = default;
};

/// reel.json, parsed and checked.
struct Manifest : ReelHead {
  std::uint64_t duration_us = 0;  ///< of one pass, the last frame's own duration included
  std::uint32_t depth_min = 0, depth_max = 0;
  Box bounds;                         ///< of all frames; empty if no frame has a point
  std::optional<PackageFile> tables;  ///< context tables that frames refer to, if there are any
  std::optional<LiveManifest> live;   ///< not of reels that are complete
  /// Some frames have fewer layers than their headers say: a live link did not bring them whole.
  bool partial = false;
  std::vector<Segment> segments;

  std::uint32_t frame_count() const;
  /// All files that the manifest names: tables, then layers, segment by segment.
  std::vector<const PackageFile*> files() const;
};

/// A larger file of tables is refused.
inline constexpr std::uint64_t kMaxTablesBytes = 1u << 20;

/// XXH3 with 64 bits and seed 0, written in reel.json as 16 lowercase hexadecimal digits.
std::uint64_t checksum_of(ByteView bytes);

/// Where one frame's part of a layer lies.
struct FrameLocation {
  std::uint32_t segment = 0;  ///< index into Manifest::segments
  std::uint32_t index = 0;    ///< of the frame in its segment
};
/// frame < manifest.frame_count().
FrameLocation locate(const Manifest& manifest, std::uint32_t frame);

/// Byte range of a frame in a layer's file. The chunks follow each other in it: geometry, colours,
/// normals.
struct ByteRange {
  std::uint64_t offset = 0, size = 0;
};
ByteRange byte_range(const LayerFile& file, std::uint32_t index);

/// Presentation time of a frame; and the frame shown at a time: the last whose time is <= t,
/// clamped to the reel. Empty reels have neither.
std::uint64_t frame_time_us(const Manifest& manifest, std::uint32_t frame);
std::uint32_t frame_at(const Manifest& manifest, std::uint64_t time_us);

/// Parses untrusted text: every count, size, name and number is checked (sizes agree with their
/// sums, frames are consecutive, times do not decrease, numbers are finite, paths stay in the
/// folder and are used once, no key comes twice), and memory is bounded by the text's length, at
/// most about 50 bytes for each of its own. A newer format version is refused by number. Unknown
/// keys are ignored. The error names the place, as in `segments[2].files[0].bytes: ...`.
Result<Manifest> parse_manifest(std::string_view text);

}  // namespace pointreel
