#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>
#include <vector>

#include "codec/files/cloud_file.h"
#include "codec/segments/pack_frame.h"
#include "codec/segments/pack_options.h"
#include "codec/segments/pack_segment.h"
#include "codec/segments/source_frames.h"
#include "pointreel/error.h"

namespace pointreel {

/// Packs segments one after another. The bytes of a segment depend on its files, those around it
/// with EncodingOptions::clean_frames, and the options only, unless PackOptions::frame_time_ms is
/// set.
class SegmentPacker {
 public:
  /// `sequence` and `options` must outlive this object.
  SegmentPacker(std::span<const CloudFrame> sequence, const PackOptions& options,
                SegmentOutput output)
      : options_(options),
        frames_(sequence, options),
        limits_(options),
        output_(std::move(output)) {}

  /// Encodes `count` frames from `first` on as one segment, within the bit rate if there is one,
  /// and writes its layer files. Runs in the calling arena. The error begins with the file at
  /// fault, if there is one.
  Result<PackedSegment> pack(std::uint32_t first, std::size_t count);
  /// The same for frames that are not in the sequence but in memory, and are not cleaned.
  Result<PackedSegment> pack(std::uint32_t first, std::vector<LoadedCloud> clouds);

  std::uint64_t late_frames() const { return limits_.late_frames(); }

 private:
  Result<PackedSegment> pack(SegmentInput& input, std::uint32_t first_frame);
  Result<PackedSegment> pack_within_rate(SegmentInput& input, std::uint32_t first_frame);
  Result<PackedSegment> pack_video_within_rate(SegmentInput& input, std::uint32_t first_frame);
  /// Bytes for so many frames at PackOptions::bitrate.
  double budget(std::size_t frames) const;

  const PackOptions& options_;
  const SourceFrames frames_;
  FrameLimits limits_;
  SegmentOutput output_;
};

}  // namespace pointreel
