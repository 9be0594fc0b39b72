#pragma once

#include <vector>

#include "datasets_synthetic/hard_case.h"

namespace pointreel {

/// Clouds that are hard for cubes, for octrees and for drawing.
void add_tree_cases(std::vector<HardCase>& cases);

}  // namespace pointreel
