#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/opengl/gl_objects.h"
#include "client/render/opengl/instance_buffer.h"
#include "client/render/region.h"

namespace pointreel {

/// Fills the holes of a splatted surface with the colours around them by pull and push (Pfister et
/// al., Surfels, section 7.6): colours are averaged over larger and larger squares, and a hole
/// takes the colours of the smallest squares around it that have any.
///
/// Pixels count as holes by the rule of FORMULAS.md, "Hole filling". Surfaces are closed, so where
/// the eye sees the inside of one, a piece in front of it is missing. For that reason the backs of
/// surfels are drawn into the depth buffer too, where they hide everything behind them. A pixel
/// that shows a back and no front before it is a hole, if fronts cover enough of some square around
/// it. A pixel that shows neither is an opening, for example between arm and body, and stays open.
/// Other backs belong to a surface with only one side, and are not filled. Where no back is
/// visible, a pixel is also closed if the pixels on all sides show something, or if most of the
/// area around it is covered, within the width of gaps between surfels.
///
/// If the signs of normals are unknown, nothing is known to be a back, and a hole shows the surface
/// behind it. There, a pixel is a hole if it is surrounded by pixels that show something nearer,
/// within the width of a random gap between surfels.
class Reconstruction {
 public:
  Reconstruction();

  /// Sets the size of the pictures to come.
  Result<void> resize(glm::ivec2 size);

  /// Draws the backs of one in `one_in` surfels into the depth buffer of the bound framebuffer.
  Result<void> draw_backs(const InstanceBuffer& instances, std::uint32_t one_in);

  /// Sets `sums`, the only attachment of the bound framebuffer, to 0 where a hole shows a surface
  /// behind it. `depth` is that of the splats, `radius` that of a typical surfel in the scene, and
  /// no surfel is nearer to the eye than the depth `nearest`, which is above 0. The caller has
  /// switched off depth test and blending.
  Result<void> clear_see_through(GLuint depth, float radius, float nearest);

  /// Textures that are sampled with linear filtering. This object owns them; they are valid until
  /// the next call.
  struct Filling {
    GLuint colors;   ///< a quarter of the picture's size; alpha: the largest share that is covered
                     ///< of any square around, with which colours are multiplied
    GLuint crowd;    ///< alpha: the share of a square of the picture that is covered
    int crowd_edge;  ///< edge of that square in pixels
  };
  /// `sums` holds the sums of weighted colours and of weights. They are 0 outside of `region`, and
  /// the result is valid only inside. `radius` is that of a typical surfel in pixels. Binds
  /// framebuffers of its own. The caller has switched off depth test and blending.
  Result<Filling> fill(const gl::Texture& sums, const PixelRect& region, float radius);

 private:
  /// Mean colours of squares of the picture, multiplied by the share of the square that is covered.
  /// The finest squares have an edge of four pixels.
  struct Level {
    gl::Texture texture;
    gl::Framebuffer framebuffer;
    glm::ivec2 size;
  };
  static Result<Level> make_level(glm::ivec2 size);
  static void draw(const Level& level, const PixelRect& part);

  gl::LateProgram back_, see_through_, pull_sums_, pull_, push_;
  gl::VertexArray points_, no_attributes_ = gl::VertexArray::create();
  glm::ivec2 size_{0};
  std::vector<Level> pulled_, pushed_;  ///< finest first; the coarsest level is not pushed
  PixelRect pulled_region_;             ///< outside of it, the pulled levels are 0
};

}  // namespace pointreel
