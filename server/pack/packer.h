#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "pointreel/draco.h"
#include "pointreel/error.h"
#include "server/pack/pack_options.h"

namespace pointreel {

/// What pack tells while it works; every member may be empty. `warn` and `frame_done` are called
/// from any thread, one call at a time.
struct PackListener {
  std::function<void(std::uint32_t total)> begin;
  std::function<void()> frame_done;
  std::function<void(const std::string& line)> warn;
  std::stop_token stop;
};

/// Median, smallest and largest; all 0 where nothing was measured.
struct Spread {
  double median = 0.0, min = 0.0, max = 0.0;
};
Spread spread_of(std::vector<double> values);

/// What came of PackOptions::train.
struct LearntTables {
  std::size_t samples = 0;   ///< frames that they were learnt from
  std::uint64_t bytes = 0;   ///< that they take in the package; 0: the built-in ones are used
  double saved_bytes = 0.0;  ///< by them, their own taken off: an estimate from the samples
};

/// What became of a segment.
struct SegmentSummary {
  std::uint32_t first_frame = 0, frames = 0;
  std::uint64_t bytes = 0;       ///< of its files
  double bits_per_second = 0.0;  ///< while it plays
  std::uint32_t depth_min = 0, depth_max = 0;
  EncodeOptions encode;     ///< that its frames were encoded with; depths are as above
  double max_error = 0.0;   ///< max_geometry_error of its frames
  bool within_rate = true;  ///< false: even the coarsest exceeds the bit rate
  int trials = 0;           ///< encodings of some frames to find out
};

struct PackSummary {
  std::uint32_t frames = 0;
  std::uint64_t points = 0;        ///< in the sources, all frames
  std::uint64_t coded_points = 0;  ///< that decoding gives
  std::uint64_t bytes = 0;         ///< of all files of the package, reel.json included
  /// Of the encoded parts, headers included; their sum is that of the segment files.
  std::uint64_t geometry_bytes = 0, color_bytes = 0, normal_bytes = 0;
  std::optional<LearntTables> learnt;
  Spread encode_ms;  ///< a frame, from the cloud in memory to the encoded bytes
  std::uint32_t depth_min = 0, depth_max = 0;
  std::string codec, entropy;
  double max_error = 0.0;         ///< of all segments, in the source's units
  std::uint64_t late_frames = 0;  ///< that took longer than frame_time_ms
  std::vector<SegmentSummary> segments;
  double seconds = 0.0;
  std::vector<std::string> warnings;
};

/// Encodes the inputs, one frame a file, and writes the package: complete or absent. Memory does
/// not grow with the number of frames: a segment's clouds (the largest are read twice rather than
/// kept) and a few frames for each thread. The package's bytes do not depend on the number of
/// threads. The error begins with the file that is at fault, where one is.
Result<PackSummary> pack(const PackOptions& options, const PackListener& listener = {});

}  // namespace pointreel
