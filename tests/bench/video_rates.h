#pragma once

#include <nlohmann/json.hpp>

#include "tests/bench/suites.h"

namespace pointreel::bench {

/// Layered depth video beside octrees, for the dense sequence: bits per second and the error that
/// `pack` states at several qualities, milliseconds per frame to pack on all cores, and to verify,
/// which is reading and decoding, on one. Prints a table while it runs.
nlohmann::json run_video(const SuiteOptions& options);

}  // namespace pointreel::bench
