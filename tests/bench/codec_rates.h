#pragma once

#include <nlohmann/json.hpp>

#include "tests/bench/suites.h"

namespace pointreel::bench {

/// Every codec at every setting that changes size, error or speed, for one frame of each scanned
/// sequence, one of a dense sequence, and the clouds in the files of the options (a quick run takes
/// a single sequence). Measures bits per point of each part, D1, largest error, PSNR of colours,
/// angle of normals, milliseconds and nanoseconds per point on one thread, milliseconds per frame
/// with frames on all cores at once, and memory. Prints a table while it runs.
nlohmann::json run_rates(const SuiteOptions& options);

}  // namespace pointreel::bench
