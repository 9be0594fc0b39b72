#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace pointreel::bench {

/// The report for people: the figures of report.json that matter to readers, and the plots.
std::string to_markdown(const nlohmann::json& report);

}  // namespace pointreel::bench
