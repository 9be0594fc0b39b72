#pragma once

#include <cstddef>
#include <span>

#include "client/render/instance.h"
#include "client/render/opengl/gl_objects.h"

namespace pointreel {

/// The instances of a picture, in memory that the GPU reads and that stays mapped, so that nothing
/// is copied on the way. There is one such buffer and not a ring of them, because the renderer
/// waits for each picture.
class InstanceBuffer final : public InstanceMemory {
 public:
  std::span<Instance> write(std::size_t count) override;
  void keep(std::size_t count) override { size_ = count; }

  GLuint name() const { return buffer_.name(); }
  std::size_t size() const { return size_; }

 private:
  gl::Buffer buffer_;
  Instance* memory_ = nullptr;
  std::size_t capacity_ = 0, size_ = 0;
};

}  // namespace pointreel
