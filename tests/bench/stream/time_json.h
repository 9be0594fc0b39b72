#pragma once

#include <nlohmann/json.hpp>

#include "client/playback/statistics.h"

namespace pointreel::bench {

/// Times as reports show them.
inline nlohmann::json json_of(const TimeSamples& samples) {
  const TimeSummary summary = samples.summary();
  return {{"median", summary.median}, {"p95", summary.p95}, {"max", summary.max}};
}

}  // namespace pointreel::bench
