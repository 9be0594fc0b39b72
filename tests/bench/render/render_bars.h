#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "tests/bench/measure.h"

namespace pointreel::bench {

/// The bars for the pictures and times that a render report contains.
std::vector<Bar> render_bars(const nlohmann::json& report);

}  // namespace pointreel::bench
