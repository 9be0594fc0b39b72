#pragma once

#include <functional>

#include <nlohmann/json.hpp>

#include "pointreel/error.h"
#include "tests/bench/report/datasets.h"

namespace pointreel::bench {

struct StructureOptions {
  int poses;        ///< for the means
  int timed_poses;  ///< how many of these are also built and traversed against the clock
  int runs;
};

/// Tables I and III of Slomp et al., Geometry Instancing, for one sequence, with the figures of the
/// paper beside ours: points per pose and, for delta = 2, 10 and 50 %, depth, loss, inner nodes,
/// leaves, and the milliseconds for building, for building recursively, and for traversing. Each
/// pose has its own cube. `done` is called after each pose.
Result<nlohmann::json> measure_structure(const Dataset& dataset, const StructureOptions& options,
                                         const std::function<void()>& done);

}  // namespace pointreel::bench
