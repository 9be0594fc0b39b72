#pragma once

#include "client/render/opengl/gl_objects.h"

namespace pointreel {

/// Darkens each pixel by how far it lies behind its neighbours: C. Boucheny, "Visualisation
/// scientifique interactive de grands volumes de données", 2009. It shows shape from depth alone,
/// so it suits clouds without normals and colours.
class EyeDomeLighting {
 public:
  EyeDomeLighting();

  /// Sets the colours (encoded as sRGB when they are written) and the depths of the pictures to
  /// come. The caller keeps the textures.
  Result<void> resize(const gl::Texture& color, const gl::Texture& depth);

  /// Darkens the picture that was drawn. `strength` is above 0; at 1, a pixel that is a hundredth
  /// farther away than all its neighbours keeps 40 % of its light. `sums` are Splatter::sums if the
  /// picture was drawn with Splatting::normalized, else null: pixels without a sum were filled, and
  /// their depth is not that of a surface. Depth test and blending are off afterwards.
  Result<void> draw(float strength, const gl::Texture* sums);

 private:
  gl::LateProgram program_;
  gl::Framebuffer picture_;  ///< without depth, which the shader reads
  GLuint depth_ = 0;
  gl::VertexArray no_attributes_ = gl::VertexArray::create();
};

}  // namespace pointreel
