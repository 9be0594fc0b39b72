#pragma once

#include <string>
#include <vector>

#include "pointreel/error.h"
#include "tests/e2e/process.h"

namespace pointreel::bench {

/// Runs one of Pointreel's programs to its end, at most ten minutes long. Fails with what it wrote
/// on standard error if its exit code is not 0.
Result<e2e::Outcome> run_program(const std::string& program,
                                 const std::vector<std::string>& arguments);

}  // namespace pointreel::bench
