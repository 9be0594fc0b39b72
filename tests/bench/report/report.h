#pragma once

#include <filesystem>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "pointreel/error.h"

namespace pointreel::bench {

/// Measures everything and writes report.json, report.md and its plots into `folder`, which is made
/// if it is missing. `quick` takes few poses, settings and runs: for a look, and for CI. Returns
/// what report.json holds.
Result<nlohmann::json> write_report(const std::filesystem::path& folder, bool quick);

/// Adds `pointreel-bench report -o FOLDER`, which does that.
void add_report_command(CLI::App& app, int& exit_code);

}  // namespace pointreel::bench
