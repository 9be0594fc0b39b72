#pragma once

#include "client/render/opengl/gl_objects.h"
#include "client/render/region.h"

namespace pointreel {

/// Smooths the outlines of what was drawn against the background. How much of a pixel is covered is
/// estimated from the pixels around it: those that are covered are counted, which gives a straight
/// outline at any angle the right share. Nothing is drawn twice or larger, as supersampling would.
class OutlineSmoother {
 public:
  OutlineSmoother();

  /// Sets the colours (encoded as sRGB when they are written) of the pictures to come. Their alpha
  /// is 1 where something was drawn. The caller keeps the texture.
  Result<void> resize(glm::ivec2 size, const gl::Texture& color);

  /// Smooths the picture within `region`. Leaves alpha as it is. Depth test and blending are off
  /// afterwards.
  Result<void> draw(const PixelRect& region);

 private:
  gl::LateProgram program_;
  GLuint color_ = 0;
  gl::Texture copy_;
  gl::Framebuffer picture_;
  gl::VertexArray no_attributes_ = gl::VertexArray::create();
};

}  // namespace pointreel
