#pragma once

#include "pointreel/error.h"
#include "tests/load/load_figures.h"

/// Many viewers in one thread, to see what a server stands. They decode nothing and look only at
/// what they need to know when a frame is whole, so that 200 of them take less than the server.
namespace pointreel {

/// An error if not all of them can connect.
Result<LoadFigures> run_load(const LoadOptions& options);

}  // namespace pointreel
