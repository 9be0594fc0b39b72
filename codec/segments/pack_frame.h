#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "codec/package/coarsening.h"
#include "codec/rate/frame_time_control.h"
#include "codec/segments/input.h"
#include "codec/segments/pack_options.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"

namespace pointreel {

/// An encoded frame, and what the summary needs to know about it.
struct PackedFrame {
  EncodedFrame encoded;
  std::optional<Chunks<std::size_t>> parts;  ///< as PackSummary::parts
  Box box;
  double encode_ms = 0.0, max_error = 0.0;
  bool colors = false, normals = false;  ///< were encoded
  bool normals_estimated = false;        ///< the source has none
  std::vector<ScalarRange> scalars;      ///< that were encoded
  bool had_radii = false, had_scalars = false;
  bool unreadable = false;  ///< SourceFrame::unreadable
  CleanReport cleaning;
  SegmentInput::Cloud source;       ///< of video, and of frames that are compared with it
  int video_side = 0;               ///< of video: pixels along the cube
  double pixel_spacings = 0.0;      ///< of video: a pixel in spacings of points, or voxels
  std::string name;                 ///< of video: its file, for errors
  Grid grid;                        ///< of video, without a limit to the octree's levels
  std::vector<std::string> unread;  ///< as LoadedCloud::unread
  std::vector<std::string> warnings;
};

/// By how much frames are encoded coarser than asked for: by the same for all frames of a segment,
/// because of the bit rate, and in addition for each frame, because of the frame time. Several
/// threads may call `of_frame` and `told`.
class FrameLimits {
 public:
  explicit FrameLimits(const PackOptions& options) {
    if (options.frame_time_ms) frame_time_.emplace(*options.frame_time_ms);
  }

  void begin_segment(int finest, const Coarsening& by) {
    finest_ = finest;
    by_ = by;
  }
  EncodeOptions of_segment(const EncodeOptions& asked) const {
    return coarsened(asked, finest_, by_);
  }

  EncodeOptions of_frame(const EncodeOptions& asked) {
    const EncodeOptions options = of_segment(asked);
    if (!frame_time_) return options;
    const std::lock_guard lock(mutex_);
    return no_deeper_than(options, frame_time_->depth());
  }

  void told(int depth, double ms) {
    if (!frame_time_) return;
    const std::lock_guard lock(mutex_);
    frame_time_->told(depth, ms);
  }

  std::uint64_t late_frames() const { return frame_time_ ? frame_time_->late() : 0; }

 private:
  int finest_ = 0;
  Coarsening by_;
  std::mutex mutex_;
  std::optional<FrameTimeControl> frame_time_;
};

/// Reads and encodes one frame. `keep_source`: PackedFrame::source is wanted. The error begins with
/// the file.
Result<PackedFrame> pack_frame(SegmentInput& input, std::size_t frame, const PackOptions& options,
                               FrameLimits& limits, bool keep_source);

}  // namespace pointreel
