#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <optional>

#include "client/bindings/frames/point_frame.h"
#include "codec/surface/clean_in_time.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel {

/// Cleans the frames of a sequence, one after another, each with the help of those around it in
/// time (clean_in_time.h). Frames that are not noisy scans of surfaces stay as they are.
class FrameCleaner {
 public:
  struct Options {
    CleanOptions clean;
    /// How many frames before and after each one help, up to kMostCleanFrames.
    std::size_t before = 2, after = 2;
  };
  /// `argument` if an option is out of range.
  static Result<FrameCleaner> make(const Options& options);

  /// Takes the next frame.
  Result<void> add(PointCloud cloud);
  /// No more frames will come.
  void end() { ended_ = true; }
  /// The next frame, cleaned; null if it waits for frames after it, or if there is none.
  Result<SharedFrame> next();

 private:
  explicit FrameCleaner(const Options& options) : options_(options) {}

  Options options_;
  std::deque<std::unique_ptr<const CleanedFrame>> window_;
  std::size_t next_ = 0;  ///< in the window
  bool ended_ = false;
};

}  // namespace pointreel
