#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "tests/bench/measure.h"

namespace pointreel::bench {

/// What the pictures and times of a render report must reach, as far as it has them.
std::vector<Bar> render_bars(const nlohmann::json& report);

}  // namespace pointreel::bench
