#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace pointreel::bench {

/// The report for readers: every figure that a person wants to see.
std::string to_render_markdown(const nlohmann::json& report);

}  // namespace pointreel::bench
