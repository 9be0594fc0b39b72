#pragma once

#include "client/render/opengl/gl_objects.h"
#include "client/render/opengl/instance_buffer.h"

namespace pointreel {

/// A vertex array with the attributes of attribute/fetch.glsl. With divisor 1 they advance with
/// each instance that is drawn, with divisor 0 with each vertex.
gl::VertexArray make_instance_array(GLuint divisor);

/// Binds the array and lets it read the instances.
void bind_instance_array(const gl::VertexArray& array, const InstanceBuffer& instances);

}  // namespace pointreel
