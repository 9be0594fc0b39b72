#pragma once

#include <vector>

#include "datasets_synthetic/hard_case.h"

namespace pointreel {

/// Clouds that are hard on cubes and octrees, and on what draws them.
void add_tree_cases(std::vector<HardCase>& cases);

}  // namespace pointreel
