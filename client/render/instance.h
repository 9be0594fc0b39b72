#pragma once

#include <cstddef>
#include <span>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

namespace pointreel {

/// A surfel, point or voxel as renderers read it: two texels of four 32-bit words, little endian.
struct Instance {
  glm::vec3 center;     ///< relative to an origin near the scene
  float radius;         ///< of the splat, or half the voxel's edge
  glm::i16vec4 normal;  ///< unit vector times 32767, or zero if unknown; w is unused
  glm::u16vec4 color;   ///< linear light, half floats; w is unused
};
static_assert(sizeof(Instance) == 32);

/// Memory for the instances of a picture, where a renderer needs it.
class InstanceMemory {
 public:
  virtual ~InstanceMemory() = default;

  /// Room for `count` new instances, which replace the old ones. The memory may be written but not
  /// read. Nothing that was submitted may still be reading the old instances. Empty if there is too
  /// little memory.
  virtual std::span<Instance> write(std::size_t count) = 0;
  /// Drops all but the first `count` of the instances that were written.
  virtual void keep(std::size_t count) = 0;
};

}  // namespace pointreel
