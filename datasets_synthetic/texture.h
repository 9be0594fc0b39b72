#pragma once

#include <cstdint>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

namespace pointreel {

/// Smooth noise, -1 to 1, about one hill or dale in each unit cube: random values at the corners of
/// the unit grid and a smooth way between them. The same on every machine.
double value_noise(const glm::dvec3& p, std::uint64_t seed);

/// Threads of this width (metres) over and under each other, seen from any side: -1 to 1.
double weave(const glm::dvec3& p, double thread);

/// The colour, lighter (or darker, `change` < 0) by that share.
glm::u8vec3 shaded(const glm::u8vec3& color, double change);

}  // namespace pointreel
