#pragma once

#include <string>
#include <vector>

#include "codec/distance/distance.h"
#include "datasets_synthetic/motion.h"
#include "datasets_synthetic/sequences.h"
#include "pointreel/cloud.h"
#include "pointreel/error.h"

namespace pointreel::bench {

/// A synthetic sequence that the report measures.
struct Dataset {
  std::string name;
  const Motion* motion;
  SequenceOptions options;                   ///< with voxels, the coordinates are voxel numbers
  std::vector<std::string> synth_arguments;  ///< these make pointreel-synth write the same clouds
  /// Bits of the grid that PSNR refers to. The peak is 2^bits - 1 cells: of the cloud's own grid,
  /// or else of the cube of the cloud.
  int peak_bits;
  int max_bits;  ///< the finest setting that is worth measuring
};

/// The five sequences of Slomp et al., Geometry Instancing, Table I, as their scanner would measure
/// them.
std::vector<Dataset> scanned_datasets();

/// The kick on a grid of 10 bits with every voxel of the surface filled, like MPEG's sequences.
Dataset dense_dataset();

/// `count` of the numbers 0 to n - 1, spread evenly and in order; all n numbers if `count` is
/// larger.
std::vector<int> spread(int n, int count);

/// The clouds of these poses, generated on all threads.
Result<std::vector<PointCloud>> make_clouds(const Dataset& dataset, const std::vector<int>& poses);

/// The distances in metres from the points of the cloud to the surface that the pose was sampled
/// from.
Result<DistanceSummary> distance_to_truth(const Dataset& dataset, int pose,
                                          const PointCloud& cloud);

}  // namespace pointreel::bench
