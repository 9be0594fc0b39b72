#pragma once

#include <span>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "client/scene/frame.h"
#include "pointreel/octree.h"

/// Colours that stand for the values of scalar fields.
namespace pointreel {

/// From dark violet over blue and green to yellow, for 0 to 1. The lightness rises evenly, so that
/// equal steps look equal. sRGB.
glm::u8vec3 ramp_color(double share);
/// The colour of a label, whatever other labels there are. Labels next to each other differ most.
glm::u8vec3 label_color(int label);
/// The colour of what has no known value.
inline constexpr glm::u8vec3 kUnknownColor{128, 128, 128};

/// The colour of each value: by its place in the range, or of its label.
std::vector<glm::u16vec3> scalar_colors(const ShownScalar& shown, std::span<const float> values);
/// The same for all nodes of a tree, from the values of its leaves. Inner nodes have the mean of
/// their leaves' colours or, of labels, the colour of most of their children.
std::vector<glm::u16vec3> scalar_node_colors(const ShownScalar& shown, const Svo& svo,
                                             std::span<const float> leaves);

}  // namespace pointreel
