#pragma once

#include <string>
#include <vector>

#include "common/surface/distance.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/sequences.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel::bench {

/// A synthetic sequence that the report measures.
struct Dataset {
  std::string name;
  const Motion* motion;
  SequenceOptions options;                   ///< with voxels, coordinates are their numbers
  std::vector<std::string> synth_arguments;  ///< what makes pointreel-synth write the same
  /// Bits of the grid that PSNR refers to; its peak is 2^bits - 1 cells, of the cloud's cube where
  /// the cloud is on no grid of its own.
  int peak_bits;
  int max_bits;  ///< finest setting worth measuring
};

/// The paper's five sequences as its scanner would give them (paper 2, Table I).
std::vector<Dataset> scanned_datasets();

/// kick on a grid of 10 bits as MPEG's sequences are, every voxel of the surface filled.
Dataset dense_dataset();

/// `count` of the numbers 0 to n - 1, spread evenly, in order; all if there are no more.
std::vector<int> spread(int n, int count);

/// The clouds of these poses, made on all threads.
Result<std::vector<PointCloud>> make_clouds(const Dataset& dataset, const std::vector<int>& poses);

/// Distances in metres of the cloud's points to the surface that the pose was sampled from.
Result<DistanceSummary> distance_to_truth(const Dataset& dataset, int pose,
                                          const PointCloud& cloud);

}  // namespace pointreel::bench
