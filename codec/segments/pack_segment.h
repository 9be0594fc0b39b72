#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "codec/segments/input.h"
#include "codec/segments/pack_frame.h"
#include "pointreel/chunks.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"
#include "pointreel/package.h"

namespace pointreel {

struct SegmentSummary {
  std::uint32_t first_frame = 0, frames = 0;
  std::uint64_t bytes = 0;       ///< of its files
  double bits_per_second = 0.0;  ///< while it plays
  std::uint32_t depth_min = 0, depth_max = 0;
  EncodeOptions encode;  ///< the options of its frames, except for the depth, which is above
  std::optional<int> video_quality = {};  ///< of video at a bit rate
  double max_error = 0.0;                 ///< the largest geometry_error of its frames
  bool within_rate = true;  ///< false: even the coarsest encoding exceeds the bit rate
  int trials = 0;  ///< how often sample frames, or video, were encoded to meet the bit rate
};

/// A segment whose files have been written: its entry in the manifest, and what the summary of the
/// package needs to know about it.
struct PackedSegment {
  Segment entry;
  SegmentSummary summary;
  Box box;                               ///< of the source's points
  bool colors = false, normals = false;  ///< were encoded in any frame
  bool normals_estimated = false;        ///< of any frame
  std::vector<ScalarRange> scalars;      ///< that were encoded
  bool had_radii = false, had_scalars = false;
  bool video = false;
  double pixel_spacings = 0.0;   ///< the largest PackedFrame::pixel_spacings
  std::set<std::string> unread;  ///< names of properties that the files have, but clouds do not
  std::uint32_t unreadable_frames = 0;
  std::uint64_t points = 0, coded_points = 0;
  std::uint64_t scalar_bytes = 0;
  Cleaning cleaning;
  std::map<NotCleaned, std::uint32_t> not_cleaned;  ///< frames, where cleaning was asked for
  std::optional<CodingError> coding_error;
  std::optional<Chunks<std::uint64_t>> parts;  ///< as PackSummary::parts
  std::vector<double> encode_ms;               ///< of each frame
  std::vector<std::string> warnings;
};

/// What a reel says of itself when it is packed like this, before there is a frame.
ReelHead head_of(const PackOptions& options);

/// A package that consists of this segment alone: what append_manifest adds to a whole one. `head`
/// says what the segment itself does not: codec, layers, tables.
Manifest manifest_of(PackedSegment segment, const Manifest& head);

struct SegmentOutput {
  std::filesystem::path folder;
  std::vector<std::string> layer_names;  ///< coarse to fine
  std::function<void()> frame_done;      ///< one call at a time; may be empty
  std::stop_token stop;
  /// When a frame of the reel is shown, from its start; empty: by PackOptions::fps.
  std::function<std::uint64_t(std::size_t frame)> time_us = {};
};

/// Encodes the frames of a segment, as many at a time as the calling arena has threads, and writes
/// its files. `first_frame` is the number of its first frame in the reel.
Result<PackedSegment> pack_segment(SegmentInput& input, std::uint32_t first_frame,
                                   const PackOptions& options, FrameLimits& limits,
                                   const SegmentOutput& output);

}  // namespace pointreel
