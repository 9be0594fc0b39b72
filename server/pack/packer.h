#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "codec/segments/pack_options.h"
#include "codec/segments/pack_segment.h"
#include "common/base/median.h"
#include "pointreel/chunks.h"
#include "pointreel/draco.h"
#include "pointreel/error.h"
#include "server/pack/audio.h"
#include "server/pack/video_trial.h"

namespace pointreel {

/// How pack reports its progress; every member may be empty. The functions are called from any
/// thread, one call at a time.
struct PackListener {
  std::function<void(std::uint32_t total)> begin;
  std::function<void()> frame_done;
  std::function<void(const std::string& line)> warn;
  std::stop_token stop;
};

/// The result of PackOptions::train.
struct LearntTables {
  std::size_t samples = 0;   ///< frames from which the tables were learnt
  std::uint64_t bytes = 0;   ///< size in the package; 0: the built-in tables are used instead
  double saved_bytes = 0.0;  ///< an estimate from the samples, minus the size of the tables
};

struct PackSummary {
  std::uint32_t frames = 0;
  std::uint64_t duration_us = 0;                    ///< of the reel
  std::optional<EncodedAudio> audio;                ///< the sound of the reel
  std::uint64_t points = 0;                         ///< in the sources of all frames
  Cleaning cleaning;                                ///< of no frame, if none was cleaned
  std::map<NotCleaned, std::uint32_t> not_cleaned;  ///< frames, where cleaning was asked for
  std::uint64_t coded_points = 0;                   ///< after decoding
  std::uint64_t bytes = 0;          ///< of all files of the package, including reel.json
  std::uint64_t segment_bytes = 0;  ///< of the layer files
  std::uint64_t scalar_bytes = 0;   ///< of these, those of scalar fields
  /// How the others divide into geometry, colours and normals, headers included. Absent with Draco,
  /// unless PackOptions::measure_parts is set.
  std::optional<Chunks<std::uint64_t>> parts;
  std::optional<LearntTables> learnt;
  Spread encode_ms;  ///< of a frame, from the cloud in memory to the encoded bytes
  std::uint32_t depth_min = 0, depth_max = 0;
  std::string codec, entropy;
  double max_error = 0.0;  ///< of all segments, in the source's units; not of video
  std::optional<CodingError> coding_error;
  double peak = 0.0;                    ///< peak_of, if there is a coding_error
  bool video = false;                   ///< whether frames were packed as video
  bool normals_estimated = false;       ///< as in the manifest
  std::optional<VideoTrial> trial;      ///< that chose between video and octrees
  std::optional<double> recorded_fps;   ///< by the median spacing of the times of a recording
  std::uint64_t late_frames = 0;        ///< frames that took longer than frame_time_ms
  std::uint32_t unreadable_frames = 0;  ///< in whose place others are shown
  std::size_t lost_parts = 0;           ///< of recordings
  std::vector<std::string> guesses;     ///< CloudSequence::guesses
  std::vector<SegmentSummary> segments;
  double seconds = 0.0;
  std::vector<std::string> warnings;
};

/// Encodes the inputs, one frame for each file, and writes the package, which is either complete or
/// absent. Memory does not grow with the number of frames: it holds the clouds of one segment (the
/// largest are read twice rather than kept) and a few frames for each thread. The package's bytes
/// do not depend on the number of threads. If a file is at fault, the error begins with its name.
Result<PackSummary> pack(const PackOptions& options, const PackListener& listener = {});

}  // namespace pointreel
