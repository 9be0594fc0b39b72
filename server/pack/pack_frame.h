#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "pointreel/error.h"
#include "pointreel/geometry.h"
#include "server/pack/grid.h"
#include "server/pack/input.h"
#include "server/pack/pack_options.h"
#include "server/rate/frame_time_control.h"
#include "server/rate/rate_control.h"

namespace pointreel {

/// A frame's bytes, and what packing tells of it.
struct PackedFrame {
  EncodedFrame encoded;
  Chunks<std::size_t> parts;
  Box box;
  double encode_ms = 0.0, max_error = 0.0;
  bool colors = false, normals = false;  ///< coded
  bool had_radii = false;
  std::vector<std::string> warnings;
};

/// What frames are made coarser by: the same for a segment, and for each what time allows. Frames
/// may be asked for and told of from several threads at once.
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

/// One frame from its file to its bytes. `shared` is the group's grid, null with a cube per frame.
Result<PackedFrame> pack_frame(SegmentInput& input, std::size_t index,
                               const std::filesystem::path& file, const Grid* shared,
                               const PackOptions& options, FrameLimits& limits);

}  // namespace pointreel
