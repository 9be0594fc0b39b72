#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

namespace pointreel {

/// A surfel, point or voxel as the shaders read it: two texels of four 32-bit words, little endian.
struct Instance {
  glm::vec3 center;     ///< relative to an origin near the scene
  float radius;         ///< of the splat, or half the voxel's edge
  glm::i16vec4 normal;  ///< unit vector times 32767, or zero if unknown; w is unused
  glm::u16vec4 color;   ///< linear light, half floats; w is unused
};
static_assert(sizeof(Instance) == 32);

}  // namespace pointreel
