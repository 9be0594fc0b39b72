#pragma once

#include <vector>

#include "datasets_synthetic/hard_case.h"

namespace pointreel {

/// Hard values: unusual positions, normals, radii and colours in files that are well formed.
void add_value_cases(std::vector<HardCase>& cases);

}  // namespace pointreel
