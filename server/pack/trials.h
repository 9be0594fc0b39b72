#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <stop_token>
#include <vector>

#include "pointreel/draco.h"
#include "pointreel/error.h"
#include "server/pack/grid.h"
#include "server/pack/input.h"
#include "server/pack/pack_options.h"
#include "server/rate/rate_control.h"

namespace pointreel {

/// What of a segment is encoded to see what a bit rate allows: some frames, spread over it.
class Trials {
 public:
  static constexpr std::size_t kFrames = 4;

  /// `shared` as of pack_frame; `input` and `files` must outlive it.
  static Result<Trials> create(const SegmentInput& input,
                               std::span<const std::filesystem::path> files, const Grid* shared,
                               const PackOptions& options);

  /// Whether there is an attribute that quality changes.
  bool have_attributes(const EncodeOptions& options) const;

  /// Leads `control` to its choice, unless it is stopped before.
  Result<void> run(RateControl& control, const std::stop_token& stop) const;

 private:
  struct Sample {
    const std::filesystem::path* file;
    SegmentInput::Cloud cloud;
    Grid grid;
  };
  std::vector<Sample> samples_;
  std::size_t frames_ = 0;
};

}  // namespace pointreel
