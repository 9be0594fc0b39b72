#pragma once

#include <cstddef>
#include <stop_token>
#include <string>
#include <vector>

#include "codec/package/grid.h"
#include "codec/rate/rate_control.h"
#include "codec/segments/input.h"
#include "pointreel/draco.h"
#include "pointreel/error.h"

namespace pointreel {

/// Encodes some frames of a segment, spread over it, to find out what a bit rate allows.
class Trials {
 public:
  static constexpr std::size_t kFrames = 4;

  /// `input` must outlive the trials.
  static Result<Trials> create(const SegmentInput& input);

  /// Whether the frames have an attribute that depends on a quality.
  bool have_attributes(const EncodeOptions& options) const;

  /// Encodes what `control` asks for until it has made its choice, or until it is stopped.
  Result<void> run(RateControl& control, const std::stop_token& stop) const;

 private:
  struct Sample {
    std::string name;  ///< of the frame
    SegmentInput::Cloud cloud;
    Grid grid;
  };
  std::vector<Sample> samples_;
  std::size_t frames_ = 0;
};

}  // namespace pointreel
