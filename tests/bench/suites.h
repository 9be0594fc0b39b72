#pragma once

#include <filesystem>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/bench/measure.h"

namespace pointreel::bench {

struct SuiteOptions {
  bool quick = false;  ///< fewer runs and sizes, for a first look or for CI
  std::vector<std::filesystem::path>
      files;  ///< clouds to measure in addition to the synthetic ones
};

/// Each suite prints its tables while it runs and returns its figures, including "bars".
nlohmann::json run_svo(const SuiteOptions& options);
nlohmann::json run_codec(const SuiteOptions& options);
nlohmann::json run_strips(const SuiteOptions& options);
nlohmann::json run_files(const SuiteOptions& options);
nlohmann::json run_scalars(const SuiteOptions& options);

/// The part of run_codec that codes colours and normals of a dense human without the tree. Adds
/// rows, and also bars unless the run is quick, because the human of a quick run has fewer voxels.
void run_attributes(const SuiteOptions& options, nlohmann::json& rows, std::vector<Bar>& bars);

}  // namespace pointreel::bench
