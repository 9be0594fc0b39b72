#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "tests/bench/measure.h"

namespace pointreel::bench {

/// What cleaning with auto should reach, compared with no cleaning, on average over the captures of
/// each group.
std::vector<Bar> surface_bars(const nlohmann::json& report);

}  // namespace pointreel::bench
