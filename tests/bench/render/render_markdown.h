#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace pointreel::bench {

/// The report as text for people.
std::string to_render_markdown(const nlohmann::json& report);

}  // namespace pointreel::bench
