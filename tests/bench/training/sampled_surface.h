#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "datasets_synthetic/random.h"
#include "tests/bench/training/relief.h"

/// Surfaces as sets of samples.
namespace pointreel::bench {

/// A point of a surface and its normal, in units of about the largest extent of the surface.
struct Sample {
  glm::dvec3 position, normal;
};
using SampledSurface = std::vector<Sample>;

/// Two unit vectors perpendicular to the normal n and to each other (Duff et al., JCGT 6(1), 2017).
void tangents(const glm::dvec3& n, glm::dvec3& u, glm::dvec3& v);

/// A random rotation, or one about the y axis only.
glm::dmat3 random_turn(Random& random, bool upright);

/// The surface with every point moved along its normal.
SampledSurface displaced(const SampledSurface& surface, const Relief& relief);

}  // namespace pointreel::bench
