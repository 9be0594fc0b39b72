#pragma once

#include "client/render/gl_objects.h"
#include "client/render/instance_buffer.h"

namespace pointreel {

/// A vertex array with the attributes of attribute/fetch.glsl, an instance for every instance that
/// is drawn (divisor 1) or for every vertex (0).
gl::VertexArray make_instance_array(GLuint divisor);

/// Lets it read the instances that were written last, and binds it.
void bind_instance_array(const gl::VertexArray& array, const InstanceBuffer& instances);

}  // namespace pointreel
