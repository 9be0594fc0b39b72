#include "client/render/opengl/instance_buffer.h"

namespace pointreel {
namespace {

/// Uniform buffers are bound in blocks of 64 KiB, so the last block must be whole.
constexpr std::size_t kUniformBlock = 65536 / sizeof(Instance);

}  // namespace

std::span<Instance> InstanceBuffer::write(std::size_t count) {
  size_ = 0;
  if (count > capacity_) {
    // Some room to grow, because frames differ in size.
    const std::size_t capacity =
        (count + count / 4 + kUniformBlock) / kUniformBlock * kUniformBlock;
    buffer_ = gl::Buffer::create();
    constexpr GLbitfield kAccess = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    const auto bytes = static_cast<GLsizeiptr>(capacity * sizeof(Instance));
    glNamedBufferStorage(buffer_.name(), bytes, nullptr, kAccess);
    memory_ = static_cast<Instance*>(glMapNamedBufferRange(buffer_.name(), 0, bytes, kAccess));
    capacity_ = memory_ ? capacity : 0;
    if (!memory_) return {};
  }
  size_ = count;
  return {memory_, count};
}

}  // namespace pointreel
