#include "client/render/opengl/instancing/instance_array.h"

#include <cstddef>

namespace pointreel {

gl::VertexArray make_instance_array(GLuint divisor) {
  gl::VertexArray array = gl::VertexArray::create();
  const GLuint name = array.name();
  glVertexArrayBindingDivisor(name, 0, divisor);
  glVertexArrayAttribFormat(name, 0, 4, GL_FLOAT, GL_FALSE, offsetof(Instance, center));
  glVertexArrayAttribFormat(name, 1, 3, GL_SHORT, GL_TRUE, offsetof(Instance, normal));
  glVertexArrayAttribFormat(name, 2, 3, GL_HALF_FLOAT, GL_FALSE, offsetof(Instance, color));
  for (GLuint attribute = 0; attribute < 3; ++attribute) {
    glVertexArrayAttribBinding(name, attribute, 0);
    glEnableVertexArrayAttrib(name, attribute);
  }
  return array;
}

void bind_instance_array(const gl::VertexArray& array, const InstanceBuffer& instances) {
  glVertexArrayVertexBuffer(array.name(), 0, instances.name(), 0, sizeof(Instance));
  glBindVertexArray(array.name());
}

}  // namespace pointreel
