#pragma once

#include <filesystem>

#include "pointreel/error.h"
#include "tests/bench/report/settings.h"

namespace pointreel::bench {

/// Peak memory of the programs that people run, in MiB.
struct PeakMemory {
  double pack = 0.0, unpack = 0.0;
};

/// Packs the clouds in the folder `input` with this setting by `pointreel-server pack`, and unpacks
/// the package again, one thread each. `scratch` is a folder for what they write.
Result<PeakMemory> measure_memory(const std::filesystem::path& input, const Setting& setting,
                                  const std::filesystem::path& scratch);

}  // namespace pointreel::bench
