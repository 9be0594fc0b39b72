#pragma once

#include "client/render/gl_objects.h"

namespace pointreel {

/// Darkens what lies behind its neighbours in the picture, by how far it does: C. Boucheny,
/// "Visualisation scientifique interactive de grands volumes de données", 2009. It shows shape from
/// depth alone, so it suits clouds without normals and colours.
class EyeDomeLighting {
 public:
  EyeDomeLighting();

  /// For pictures whose colours, encoded as sRGB when they are written, and depths are in these
  /// textures, which stay the caller's.
  Result<void> resize(const gl::Texture& color, const gl::Texture& depth);

  /// Of a drawn picture. strength > 0: at 1, what lies a hundredth farther than all that is around
  /// it keeps 40 % of its light. `sums` are those of splats, if they were drawn by their means: a
  /// pixel without any was filled, and its depth is none of a surface. Depth test and blending are
  /// off afterwards.
  Result<void> draw(float strength, const gl::Texture* sums);

 private:
  gl::LateProgram program_;
  gl::Framebuffer picture_;  ///< colour alone: the depth is read
  GLuint depth_ = 0;         ///< the caller's
  gl::VertexArray no_attributes_ = gl::VertexArray::create();
};

}  // namespace pointreel
