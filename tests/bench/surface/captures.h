#pragma once

#include <string>
#include <vector>

#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/sequences.h"

namespace pointreel::bench {

/// A noisy sequence whose true surface is known.
struct Capture {
  std::string group;  ///< captures of a group are averaged
  const Motion* motion;
  SequenceOptions options;
};

inline constexpr const char* kScans = "scans";
inline constexpr const char* kDepthCameras = "depth cameras";

/// The five scanned sequences, and three of them as depth cameras with 1 cm of noise measure them.
/// A quick run takes one of each.
std::vector<Capture> surface_captures(bool quick);

}  // namespace pointreel::bench
