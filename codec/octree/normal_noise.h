#pragma once

#include <span>

#include "codec/octree/attribute_coder.h"
#include "codec/octree/attribute_value.h"
#include "pointreel/octree.h"

namespace pointreel {

/// The noise of a tree's normals: the standard deviation of one tangential component, in values
/// (normal_space.h). It is found from leaves that share a parent on the deepest level that has
/// enough of them. They lie so close to each other that their normals hardly differ by the shape of
/// the surface. 0 if there are too few. `leaves`: the value of each leaf.
double normal_noise(const Svo& svo, std::span<const Short4> leaves);

/// Steps that are not finer than the noise asks for: what is finer would take many bits to keep
/// noise as it is.
CoefficientSteps no_finer_than_noise(const CoefficientSteps& steps, double noise);

}  // namespace pointreel
