#pragma once

#include <functional>
#include <vector>

#include <nlohmann/json.hpp>

#include "pointreel/error.h"
#include "tests/bench/report/datasets.h"
#include "tests/bench/report/settings.h"

namespace pointreel::bench {

/// Sizes, errors and times of one sequence, with a row for each setting. Sizes and errors are means
/// over the poses; times are medians over all runs of all poses. Distances are in metres of the
/// scanned scene. `done` is called after each setting of each pose.
Result<nlohmann::json> measure_rates(const Dataset& dataset, const std::vector<int>& poses,
                                     const std::vector<Setting>& settings, int runs,
                                     const std::function<void()>& done);

}  // namespace pointreel::bench
