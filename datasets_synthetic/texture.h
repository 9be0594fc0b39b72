#pragma once

#include <cstdint>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

namespace pointreel {

/// Smooth noise from -1 to 1 with about one hill or valley in each unit cube: random values at the
/// points of the integer grid, interpolated smoothly. The same on every machine.
double value_noise(const glm::dvec3& p, std::uint64_t seed);

/// The pattern of woven cloth, -1 to 1, with threads of the given width in metres. It looks the
/// same from every side.
double weave(const glm::dvec3& p, double thread);

/// The colour made lighter by the share `change`, or darker where `change` is negative.
glm::u8vec3 shaded(const glm::u8vec3& color, double change);

}  // namespace pointreel
