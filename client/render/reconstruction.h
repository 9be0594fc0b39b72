#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "client/render/gl_objects.h"
#include "client/render/instance_buffer.h"
#include "client/render/region.h"

namespace pointreel {

/// Fills the holes of a splatted surface from what is around them, by pull and push (paper 1,
/// section 7.6): the colours are averaged over larger and larger squares, and a hole gets those of
/// the smallest squares around it in which there are any.
///
/// What is a hole? Surfaces are closed, so where the eye sees the inside of one something is
/// missing in front of it. The backs of surfels therefore go into the depth buffer too, and hide
/// what is behind them: a pixel that is covered by a back and by no front before it is a hole,
/// however large; one that is covered by neither is an opening, between arm and body, and stays.
/// Far from any front, backs are those of a surface that has but one side. And where no back was
/// seen, pixels are closed around which something was seen on all sides, or that are covered for
/// the most part all around, as far as gaps between surfels reach.
class Reconstruction {
 public:
  Reconstruction();

  /// For pictures of this size.
  Result<void> resize(glm::ivec2 size);

  /// Draws the backs of some of the surfels into the depth of the bound framebuffer.
  Result<void> draw_backs(const InstanceBuffer& instances);

  /// Textures to be sampled between texels; they stay this object's, until the next call.
  struct Filling {
    GLuint colors;   ///< of a quarter of the picture's size; alpha is 0 where no colour is near
    GLuint crowd;    ///< alpha: how much of a square of the picture is covered
    int crowd_edge;  ///< of the square in pixels
  };
  /// `sums` holds the sums of weighted colours and of weights, all 0 outside of `region`, and only
  /// there is the result of any use. `radius`: of a surfel in pixels. Binds framebuffers of its
  /// own; depth test and blending are off.
  Result<Filling> fill(const gl::Texture& sums, const PixelRect& region, float radius);

 private:
  /// Means of squares, from an edge of four pixels on; premultiplied by how much is covered.
  struct Level {
    gl::Texture texture;
    gl::Framebuffer framebuffer;
    glm::ivec2 size;
  };
  static Result<Level> make_level(glm::ivec2 size);
  static void draw(const Level& level, const PixelRect& part);

  gl::LateProgram back_, pull_sums_, pull_, push_;
  gl::VertexArray points_, no_attributes_ = gl::VertexArray::create();
  glm::ivec2 size_{0};
  std::vector<Level> pulled_, pushed_;  ///< the coarsest is not pushed
  PixelRect pulled_region_;             ///< outside of it, what was pulled is 0
};

}  // namespace pointreel
