#pragma once

#include <functional>

#include <nlohmann/json.hpp>

#include "pointreel/error.h"
#include "tests/bench/report/datasets.h"

namespace pointreel::bench {

/// How the structure of a sequence is measured.
struct StructureOptions {
  int poses;        ///< that the means are taken over
  int timed_poses;  ///< of which the octree is built and traversed against the clock
  int runs;
};

/// Tables I and III of paper 2 for one sequence, with the paper's figures beside ours: points a
/// pose, and for delta 2, 10 and 50 % depth, loss, inner nodes, leaves, and the milliseconds of
/// building and traversing, and of building recursively as the paper does. A cube for each pose.
/// `done` is called after each pose.
Result<nlohmann::json> measure_structure(const Dataset& dataset, const StructureOptions& options,
                                         const std::function<void()>& done);

}  // namespace pointreel::bench
