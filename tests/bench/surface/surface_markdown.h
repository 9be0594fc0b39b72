#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace pointreel::bench {

/// The report for people: tables, and links to the plots.
std::string to_surface_markdown(const nlohmann::json& report);

}  // namespace pointreel::bench
