#pragma once

#include <string>
#include <vector>

#include "datasets_synthetic/hard_case.h"

namespace pointreel {

/// All hard cases, in order of stage and kind, with the same bytes every time and on every machine.
/// The expectations follow from how the files were made, never from reading them.
std::vector<HardCase> hard_cases();

/// The JSON that is written beside the files: every member of the cases except the bytes.
std::string hard_manifest(const std::vector<HardCase>& cases);

}  // namespace pointreel
