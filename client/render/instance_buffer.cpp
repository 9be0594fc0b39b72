#include "client/render/instance_buffer.h"

namespace pointreel {
namespace {

/// Parts begin where uniform and texture buffers may: at multiples of 64 KiB.
constexpr std::size_t kGranule = 65536 / sizeof(Instance);

}  // namespace

std::span<Instance> InstanceBuffer::write(std::size_t count) {
  size_ = 0;
  if (count > capacity_) {
    // With some room to grow: frames differ in size.
    const std::size_t capacity = (count + count / 4 + kGranule) / kGranule * kGranule;
    buffer_ = gl::Buffer::create();
    fences_ = {};
    constexpr GLbitfield kAccess = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    const auto bytes = static_cast<GLsizeiptr>(kParts * capacity * sizeof(Instance));
    glNamedBufferStorage(buffer_.name(), bytes, nullptr, kAccess);
    memory_ = static_cast<Instance*>(glMapNamedBufferRange(buffer_.name(), 0, bytes, kAccess));
    capacity_ = memory_ ? capacity : 0;
    if (!memory_) return {};
  }
  part_ = (part_ + 1) % kParts;
  fences_[part_].wait();
  size_ = count;
  return {memory_ + part_ * capacity_, count};
}

void InstanceBuffer::drawn() { fences_[part_] = gl::Fence::create(); }

GLintptr InstanceBuffer::offset() const {
  return static_cast<GLintptr>(part_ * capacity_ * sizeof(Instance));
}

}  // namespace pointreel
