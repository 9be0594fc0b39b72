#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "common/surface/distance.h"

namespace pointreel::bench {

/// Adds `pointreel-bench compare A B`: every metric of distance.h for two files of a user, as a
/// table and as JSON. Runs where the command line is parsed and sets its exit code: 0, or 1 with
/// one line on standard error.
void add_compare_command(CLI::App& app, int& exit_code);

/// Mean squares, distances and peak signal-to-noise ratios, `peak` in the units of the clouds;
/// normals in degrees. What the clouds have no attributes for is missing, what is infinite null.
nlohmann::json to_json(const OneWayDistance& distance, double peak);

/// "a_to_b", "b_to_a" and "symmetric", each as above.
nlohmann::json to_json(const CloudDistance& distance, double peak);

}  // namespace pointreel::bench
