#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "tests/bench/suites.h"

namespace pointreel::bench {

/// One frame to code, on a grid of 2^bits cells a side.
struct RateSource {
  std::string name;
  PointCloud cloud;
  Cube cube;
  int bits = 10;
};

/// A frame of each synthetic sequence as the scanner gives it, one of a dense sequence, and those
/// of the options' files. Quick: one sequence.
Result<std::vector<RateSource>> rate_sources(const SuiteOptions& options);

/// Every codec at every setting that changes size, error or speed: of each source bits a point of
/// each part, D1, largest error, PSNR of colours, angle of normals, milliseconds and nanoseconds a
/// point of one thread, milliseconds a frame with frames on all cores at once, and memory.
/// Prints a table as it goes.
nlohmann::json run_rates(const SuiteOptions& options);

}  // namespace pointreel::bench
