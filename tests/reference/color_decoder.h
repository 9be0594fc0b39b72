#pragma once

#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel::reference {

struct Values {
  std::vector<glm::ivec3> nodes;
  bool exact = false;  ///< the layers are exact
};

/// Decodes the values of the nodes at the last layer's last level, in Morton order, from the
/// payloads of the layers' chunks, as FORMAT.md describes it ("Transformed attributes"): one number
/// at a time, and with maps from cells to nodes. `leaves`: the cells at that level. `layer_ends`:
/// the last level of each layer. Fails if the payloads do not fit these.
/// `normals`: whether they are normals, and not colours.
Result<Values> decode_values(const std::vector<glm::uvec3>& leaves,
                             const std::vector<Bytes>& layers, const std::vector<int>& layer_ends,
                             bool normals);

/// The colour of a value, where 65535 is full intensity, in a frame with colours of 8 or 16 bits.
glm::u16vec3 color_of_value(const glm::ivec3& value, int bits);
/// The same for exact layers, which have colours of 8 bits.
glm::u16vec3 color_of_exact_value(const glm::ivec3& value);

/// The 8-bit colours of the same nodes, from valid payloads.
std::vector<glm::u16vec3> decode_colors(const std::vector<glm::uvec3>& leaves,
                                        const std::vector<Bytes>& layers,
                                        const std::vector<int>& layer_ends);

}  // namespace pointreel::reference
