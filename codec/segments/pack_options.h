#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

#include "codec/files/cloud_file.h"
#include "codec/package/encoding_options.h"

namespace pointreel {

inline constexpr int kMostVideoEffort = 9, kMostSegmentFrames = 100'000;

/// How frames are packed as video.
struct VideoPackOptions {
  std::uint32_t segment_frames = 48;  ///< instead of PackOptions::segment_frames
  std::uint32_t group_frames = 24;    ///< frames of a group, 1 to kMostGroupFrames
  int quality = 64;                   ///< 1 to 100, of depth and colours together
  int effort = 4;                     ///< 0, the fastest, to kMostVideoEffort, the smallest
};

/// What to pack, and where to. An empty `name` stands for that of the output folder without
/// ".reel".
struct PackOptions : EncodingOptions {
  /// How `inputs` are listed.
  ListOptions listing(std::stop_token stop = {}) const {
    return {topic, max_memory, best_effort, reading,
            [stop = std::move(stop)] { return stop.stop_requested(); }};
  }

  std::vector<std::filesystem::path> inputs;  ///< folders and files, as list_cloud_files takes them
  std::filesystem::path output;
  std::string topic;  ///< of recordings that have several
  Reading reading;    ///< what is not to be guessed of how the frames are read
  /// Take the axis that points up from the first file where its format tells it, instead of `up`.
  bool up_of_files = false;
  /// Take the times of frames from recordings, instead of `fps`.
  bool times_of_files = false;
  /// With Entropy::context: learn context tables from the frames, and use them if that makes the
  /// package smaller.
  bool train = false;
  /// With Draco: measure how the bytes divide into geometry, colours and normals, which takes two
  /// more encodes of each frame. Of octrees this is known anyway.
  bool measure_parts = false;
  /// Bits per second, above 0, that no segment may exceed on average. RateControl then chooses the
  /// encode options of each segment, none of them finer than `encode`, and QualitySearch the
  /// quality of video.
  std::optional<double> bitrate;
  /// Each frame gets its own bounding cube, instead of one that all frames of a segment share
  /// (common/FORMULAS.md, "Cube of a frame").
  bool cube_per_frame = false;
  std::optional<std::filesystem::path> audio;  ///< a file whose sound the package gets
  std::uint32_t segment_frames = 30;           ///< frames of a segment, 1 to kMostSegmentFrames
  /// Show the frame before for as long as frames are missing by the numbers in their names.
  bool keep_gaps = false;
  /// Pack frames that collapse because of their cube (collapse.h), and segments that exceed the bit
  /// rate at their coarsest; leave out strays (strays.h) and damaged parts of recordings; show
  /// another frame in place of one that cannot be read: all with a warning. Otherwise these are
  /// errors.
  bool best_effort = false;
  /// Encode layered depth video on top of octrees of few levels; `encode` holds octree options,
  /// which choose the size of its pixels.
  std::optional<VideoPackOptions> video;
  /// Without `video`: what it is to be if a trial on some of the frames shows that this pays.
  std::optional<VideoPackOptions> video_if_it_pays;
  bool force = false;  ///< replace a package that is already there

  void pack_as_video(VideoPackOptions how) {
    video = how;
    video_if_it_pays.reset();
    segment_frames = how.segment_frames;
  }
};

}  // namespace pointreel
