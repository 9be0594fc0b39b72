#pragma once

#include <filesystem>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/bench/measure.h"

namespace pointreel::bench {

struct SuiteOptions {
  bool quick = false;                        ///< fewer runs and sizes, for a look or for CI
  std::vector<std::filesystem::path> files;  ///< real clouds to measure beside the synthetic ones
};

/// Each prints its table as it goes and returns what it measured, "bars" included.
nlohmann::json run_svo(const SuiteOptions& options);
nlohmann::json run_codec(const SuiteOptions& options);

/// Part of run_codec: colours and normals of a dense human, without the tree. Adds rows, and bars
/// unless it is a quick run, whose human has fewer voxels.
void run_attributes(const SuiteOptions& options, nlohmann::json& rows, std::vector<Bar>& bars);

}  // namespace pointreel::bench
