#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "client/bindings/frames/point_frame.h"
#include "client/source/source.h"
#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// The frames of a reel that are shown (shown_frames), numbered from 0. May be used by several
/// threads at once.
class ReelFrames {
 public:
  explicit ReelFrames(std::unique_ptr<Source> source)
      : source_(std::move(source)), shown_(shown_frames(source_->manifest())) {}

  Source& source() const { return *source_; }
  const Manifest& manifest() const { return source_->manifest(); }
  std::uint32_t size() const { return static_cast<std::uint32_t>(shown_.size()); }

  /// When a frame is shown, in microseconds from the start of the reel. `argument` if there is no
  /// such frame, as for read().
  Result<std::uint64_t> time_us(std::uint32_t index) const;
  /// Fetches a frame and decodes it.
  Result<SharedFrame> read(std::uint32_t index, const ReadLimits& limits) const;

 private:
  /// The number in the package.
  Result<std::uint32_t> number(std::uint32_t index) const;

  const std::unique_ptr<Source> source_;
  const std::vector<std::uint32_t> shown_;
};

}  // namespace pointreel
