#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "client/render/gl_objects.h"

namespace pointreel {

/// What the graphics processor gets for each surfel, point or voxel, as the shaders read it: two
/// texels of four 32-bit words, little endian.
struct Instance {
  glm::vec3 center;     ///< relative to an origin near the scene
  float radius;         ///< of the splat, or half the voxel's edge
  glm::i16vec4 normal;  ///< unit vector times 32767, or zero where unknown; w unused
  glm::u16vec4 color;   ///< linear light, half floats; w unused
};
static_assert(sizeof(Instance) == 32);

/// Instances in memory that the graphics processor reads while the next frame's are written: a ring
/// of three parts of one buffer that stays mapped, so that nothing is copied on the way.
class InstanceBuffer {
 public:
  static constexpr std::size_t kParts = 3;

  InstanceBuffer() = default;
  InstanceBuffer(InstanceBuffer&&) = default;
  InstanceBuffer& operator=(InstanceBuffer&&) = default;
  ~InstanceBuffer() = default;

  /// Room for new instances, to be filled before they are drawn; the memory must not be read. What
  /// was written before is no longer drawn. Waits until the part of the ring is drawn with; empty
  /// if the driver has no such memory.
  std::span<Instance> write(std::size_t count);
  /// Only the first `count` of what was written are drawn.
  void keep(std::size_t count) { size_ = count; }
  /// After the last draw call that reads what was written.
  void drawn();

  GLuint name() const { return buffer_.name(); }
  GLintptr offset() const;  ///< of the instances in bytes; a multiple of 64 KiB
  std::size_t size() const { return size_; }

 private:
  gl::Buffer buffer_;
  Instance* memory_ = nullptr;
  std::size_t capacity_ = 0;  ///< of each part
  std::size_t part_ = 0, size_ = 0;
  std::array<gl::Fence, kParts> fences_;
};

}  // namespace pointreel
