#pragma once

#include <cstddef>
#include <string>

#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/sequences.h"
#include "pointreel/error.h"

namespace pointreel {

struct SequenceJob {
  std::string output;  ///< folder
  bool force = false;  ///< replace it if it holds nothing but frames
  int frames = 1;      ///< > 0
  SequenceOptions options;
};

/// Points a frame.
struct SequenceSummary {
  double mean_points = 0.0;
  std::size_t min_points = 0, max_points = 0;
  double seconds = 0.0;
};

/// Writes frame_0000.ply, frame_0001.ply, ... into a folder that is complete or absent, several
/// frames at a time (TBB's threads), with a bar on a terminal. The error names file or frame.
Result<SequenceSummary> write_sequence(const Motion& motion, const SequenceJob& job);

}  // namespace pointreel
