#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/command_line/command.h"
#include "pointreel/error.h"
#include "tests/bench/measure.h"

namespace pointreel::bench {

/// The options of every chapter.
struct StreamOptions {
  bool quick = false;             ///< fewer repetitions and frames, for a first look or for CI
  std::filesystem::path scratch;  ///< a folder to write to, which outlives the chapters
};

/// A part of what a command measures. It returns its figures, adds its bars and prints nothing. It
/// fails if it could not measure.
struct StreamChapter {
  std::string name;   ///< the key in the report and the name for --only
  std::string about;  ///< one line for --help
  Result<nlohmann::json> (*run)(const StreamOptions&, std::vector<Bar>&);
};

/// Adds `pointreel-bench NAME`, which runs all or some of these chapters in their order and prints
/// their figures and bars.
void add_chapters_command(cli::Command app, int& exit_code, const std::string& name,
                          const std::string& about, const std::vector<StreamChapter>& chapters);

}  // namespace pointreel::bench
