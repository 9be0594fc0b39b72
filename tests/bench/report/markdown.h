#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace pointreel::bench {

/// The report for readers: every figure of report.json that a person wants to see, and the plots.
std::string to_markdown(const nlohmann::json& report);

}  // namespace pointreel::bench
