#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <stop_token>

#include "codec/files/cloud_file.h"
#include "pointreel/error.h"
#include "server/pack/pack_frame.h"
#include "server/pack/pack_options.h"
#include "server/pack/pack_segment.h"

namespace pointreel {

/// Packs segments one after another. The bytes of a segment depend on its files and the options
/// only, unless PackOptions::frame_time_ms is set.
class SegmentPacker {
 public:
  /// `options` must outlive this object.
  SegmentPacker(const PackOptions& options, SegmentOutput output)
      : options_(options), limits_(options), output_(std::move(output)) {}

  /// Encodes the files as one segment, within the bit rate if there is one, and writes its layer
  /// files. Runs in the calling arena. The error begins with the file at fault, if there is one.
  Result<PackedSegment> pack(std::span<const CloudFrame> files, std::uint32_t first_frame);

  std::uint64_t late_frames() const { return limits_.late_frames(); }

 private:
  Result<PackedSegment> pack_within_rate(SegmentInput& input, std::uint32_t first_frame);
  Result<PackedSegment> pack_video_within_rate(SegmentInput& input, std::uint32_t first_frame);
  /// Bytes for so many frames at PackOptions::bitrate.
  double budget(std::size_t frames) const;

  const PackOptions& options_;
  FrameLimits limits_;
  SegmentOutput output_;
};

}  // namespace pointreel
