#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "pointreel/error.h"
#include "tests/bench/measure.h"

namespace pointreel::bench {

/// What every chapter is told.
struct StreamOptions {
  bool quick = false;             ///< fewer repetitions and frames, for a look or for CI
  std::filesystem::path scratch;  ///< a folder to write to, which outlives the chapters
};

/// One of the things that a command measures. It returns its figures, adds the bars that
/// they must reach, and prints nothing: an error if it could not measure.
struct StreamChapter {
  std::string name;   ///< of the key in the report and for --only
  std::string about;  ///< one line
  Result<nlohmann::json> (*run)(const StreamOptions&, std::vector<Bar>&);
};

/// `pointreel-bench NAME`: all of these or some, in their order; prints their figures, and each
/// bar.
void add_chapters_command(CLI::App& app, int& exit_code, const std::string& name,
                          const std::string& about, const std::vector<StreamChapter>& chapters);

}  // namespace pointreel::bench
