#pragma once

#include <cstddef>
#include <string>

#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/sequences.h"
#include "pointreel/error.h"

namespace pointreel {

struct SequenceJob {
  std::string output;  ///< the folder to write to
  bool force = false;  ///< replace the folder if it holds nothing but frames
  int frames = 1;      ///< > 0
  SequenceOptions options;
};

struct SequenceSummary {
  double mean_points = 0.0;  ///< per frame
  std::size_t min_points = 0, max_points = 0;
  double seconds = 0.0;  ///< that writing took
};

/// Writes frame_0000.ply, frame_0001.ply, ... into a folder that appears only once it is complete.
/// Writes several frames at a time, on TBB's threads, and shows a progress bar on a terminal. The
/// error names the file or the frame.
Result<SequenceSummary> write_sequence(const Motion& motion, const SequenceJob& job);

}  // namespace pointreel
