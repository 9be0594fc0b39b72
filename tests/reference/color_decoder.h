#pragma once

#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel::reference {

/// Values of the nodes at the last layer's last level, in Morton order, decoded from the payloads
/// of the layers' chunks as FORMAT.md says it ("Transformed attributes"), one number at a time,
/// with maps from cells to nodes. `leaves` are the cells at that level; `layer_ends` the layers'
/// last levels. Payloads that do not fit them are errors.
Result<std::vector<glm::ivec3>> decode_values(const std::vector<glm::uvec3>& leaves,
                                              const std::vector<Bytes>& layers,
                                              const std::vector<int>& layer_ends);

/// The colour, 65535 for 1, that values stand for in a frame whose colours have 8 or 16 bits.
glm::u16vec3 color_of_value(const glm::ivec3& value, int bits);

/// Colours of 8 bits of the same nodes, from good payloads.
std::vector<glm::u16vec3> decode_colors(const std::vector<glm::uvec3>& leaves,
                                        const std::vector<Bytes>& layers,
                                        const std::vector<int>& layer_ends);

}  // namespace pointreel::reference
