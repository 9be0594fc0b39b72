#pragma once

#include <cstddef>
#include <vector>

#include <glm/glm.hpp>

#include "datasets_synthetic/random.h"
#include "tests/bench/training/sampled_surface.h"

/// Furniture and animals, to train on.
namespace pointreel::bench {

/// Part of a thing: a box, or a rod with round ends.
struct ThingPart {
  glm::dvec3 from, to;  ///< the corners of the box, or the ends of the rod
  double radius;        ///< 0: a box
};

/// Points on the parts of a thing that are not inside of others. Points on a part are evenly
/// spread; each part has as many as its share of the surface.
SampledSurface sample_thing(const std::vector<ThingPart>& parts, std::size_t count, Random& random);

/// A table or shelf, with things on it.
std::vector<ThingPart> furniture(Random& random);

/// A body on four legs, with a neck, a head and a tail.
std::vector<ThingPart> animal(Random& random);

}  // namespace pointreel::bench
