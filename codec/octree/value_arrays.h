#pragma once

#include <span>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "codec/octree/int4.h"

/// Turns many values into attributes, four at a time.
namespace pointreel {

/// color_from_value of each value. `colors` has room for as many.
void colors_from_values(std::span<const Short4> values, glm::u16vec3* colors);

/// normal_from_value of each value. `normals` has room for as many.
void normals_from_values(std::span<const Short4> values, glm::vec3* normals);

}  // namespace pointreel
