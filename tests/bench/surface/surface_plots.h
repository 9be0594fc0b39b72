#pragma once

#include <filesystem>

#include <nlohmann/json.hpp>

#include "pointreel/error.h"

namespace pointreel::bench {

/// Draws surface_radius.svg, surface_beta.svg and surface_rate.svg, with a column for each group.
Result<void> draw_surface_plots(const std::filesystem::path& folder, const nlohmann::json& report);

}  // namespace pointreel::bench
