#pragma once

#include <nlohmann/json.hpp>

#include "pointreel/error.h"

namespace pointreel::bench {

/// Compares pictures of strips and of splats of the same surfels with the surface that they were
/// sampled from, and prints a row for each scene, view and way to draw.
Result<nlohmann::json> measure_strip_pictures();

}  // namespace pointreel::bench
