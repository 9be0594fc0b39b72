#pragma once

#include <glm/glm.hpp>

#include "client/render/opengl/gl_objects.h"
#include "client/render/region.h"
#include "client/render/software/picture.h"

namespace pointreel {

/// A picture as a texture, to show it in a window. Needs the same current OpenGL context from the
/// first call to destruction.
class PictureTexture {
 public:
  /// Copies the part of the picture to the texture. The rest of the texture keeps what it had.
  void upload(const Picture& picture, const PixelRect& part);

  /// GL_RGBA8 with linear filtering, whose first row is the lowest; alpha is read as 1.
  GLuint name() const { return texture_.name(); }
  /// With this texture attached.
  GLuint framebuffer() const { return framebuffer_.name(); }

 private:
  gl::Texture texture_;
  gl::Framebuffer framebuffer_;
  glm::ivec2 size_{0};
};

}  // namespace pointreel
