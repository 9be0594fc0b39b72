#pragma once

#include "pointreel/error.h"
#include "tests/load/load_figures.h"

/// Many viewers in one thread, to find out how many a server can handle. They decode nothing and
/// look only at the bytes that tell when a frame is complete, so that 200 of them need less
/// processor time than the server.
namespace pointreel {

/// Measures the frame delays of many viewers. Fails unless all of them can connect.
Result<LoadFigures> run_load(const LoadOptions& options);

}  // namespace pointreel
