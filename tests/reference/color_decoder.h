#pragma once

#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "common/base/bytes.h"

namespace pointreel::reference {

/// Colours of the nodes at the last layer's last level, in Morton order, decoded from the payloads
/// of the layers' chunks as FORMAT.md says it ("Transformed colours"), one number at a time, with
/// maps from cells to nodes. `leaves` are the cells at that level; `layer_ends` the layers' last
/// levels. The payloads are good ones.
std::vector<glm::u16vec3> decode_colors(const std::vector<glm::uvec3>& leaves,
                                        const std::vector<Bytes>& layers,
                                        const std::vector<int>& layer_ends);

}  // namespace pointreel::reference
