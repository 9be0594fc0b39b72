#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace pointreel::e2e {

/// Runs `pointreel play ARGUMENTS... --duration SECONDS --json -` and returns its report once that
/// is `enough`. The player runs for a second and then twice as long each time, because how much
/// arrives in a second depends on the machine. Gives up after a minute of playing and returns the
/// last report. The result is discarded if the report is not JSON.
nlohmann::json play_until(const std::vector<std::string>& arguments,
                          const std::function<bool(const nlohmann::json&)>& enough);

}  // namespace pointreel::e2e
