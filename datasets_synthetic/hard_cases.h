#pragma once

#include <string>
#include <vector>

#include "datasets_synthetic/hard_case.h"

namespace pointreel {

/// All of them, in order of stage and kind: the same bytes every time and on every machine.
/// Expectations come from how the files were made, never from reading them.
std::vector<HardCase> hard_cases();

/// What stands beside the files: every member of the cases but the bytes, as JSON.
std::string hard_manifest(const std::vector<HardCase>& cases);

}  // namespace pointreel
