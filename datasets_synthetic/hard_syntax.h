#pragma once

#include <vector>

#include "datasets_synthetic/hard_case.h"

namespace pointreel {

/// Hard syntax: PLY files that are unusual but valid, and invalid files that must be refused with a
/// message that leads to the fault.
void add_syntax_cases(std::vector<HardCase>& cases);

}  // namespace pointreel
