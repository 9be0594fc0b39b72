#pragma once

#include <filesystem>
#include <vector>

#include <nlohmann/json.hpp>

namespace pointreel::bench {

struct SuiteOptions {
  bool quick = false;                        ///< fewer runs and sizes, for a look or for CI
  std::vector<std::filesystem::path> files;  ///< real clouds to measure beside the synthetic ones
};

/// Each prints its table as it goes and returns what it measured, "bars" included.
nlohmann::json run_svo(const SuiteOptions& options);
nlohmann::json run_codec(const SuiteOptions& options);

}  // namespace pointreel::bench
