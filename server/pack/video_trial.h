#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "codec/files/cloud_file.h"
#include "codec/segments/pack_options.h"
#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

struct PackedSegment;

/// What shorter sequences and sparser frames would save is not worth the trial, and the time that
/// video takes.
inline constexpr std::size_t kFewestVideoFrames = 16, kFewestVideoPoints = 200'000;

/// Some neighbouring frames packed both as video and as octrees with voxels about twice as large as
/// the pixels of the video, and with colours that are no better.
struct VideoTrial {
  struct Outcome {
    double bytes = 0.0;  ///< of a frame, on average
    CodingError error;   ///< of one frame
  };
  std::size_t frames = 0;
  double peak = 0.0;       ///< what PSNR is relative to
  int octree_quality = 0;  ///< of colours: as asked for, or lower
  Outcome video, octrees;

  /// Whether video takes fewer bytes and is as close to the source.
  bool video_pays() const;
  /// `limit` if a segment that was packed as video is not like the frames that were tried.
  Result<void> holds_for(const PackedSegment& segment, const PackOptions& options) const;
};

/// Makes the trial of PackOptions::video_if_it_pays, and packs as video if that pays. Returns the
/// trial. There is none, and octrees stay, if the sequence is too short, or its frames have too few
/// or too many points, for video to pay; if they have scalar fields to encode, which video cannot
/// carry; and if they cannot be encoded as video. Runs in the calling arena. Fails only if it is
/// stopped.
Result<std::optional<VideoTrial>> choose_video(std::span<const CloudFrame> frames,
                                               PackOptions& options, const std::stop_token& stop);

/// For people, indented as the lines of pack's summary.
std::vector<std::string> trial_lines(const VideoTrial& trial);
/// null if there was no trial.
nlohmann::ordered_json trial_json(const std::optional<VideoTrial>& trial);

}  // namespace pointreel
