#pragma once

#include <filesystem>

#include "pointreel/error.h"
#include "tests/bench/report/settings.h"

namespace pointreel::bench {

/// The peak memory of `pointreel-server pack` and `unpack` in MiB.
struct PeakMemory {
  double pack = 0.0, unpack = 0.0;
};

/// Packs the clouds in the folder `input` with this setting and unpacks the package again, on one
/// thread each. The programs write to the folder `scratch`.
Result<PeakMemory> measure_memory(const std::filesystem::path& input, const Setting& setting,
                                  const std::filesystem::path& scratch);

}  // namespace pointreel::bench
