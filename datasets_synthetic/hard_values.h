#pragma once

#include <vector>

#include "datasets_synthetic/hard_case.h"

namespace pointreel {

/// Hard values: positions, normals, radii and colours of clouds whose files are well formed.
void add_value_cases(std::vector<HardCase>& cases);

}  // namespace pointreel
