#pragma once

#include <glm/glm.hpp>

#include "client/render/gl_objects.h"
#include "client/render/instancing/method.h"
#include "client/render/reconstruction.h"
#include "client/render/region.h"
#include "client/scene/draw_options.h"

namespace pointreel {

/// What the passes of a mode multiply radii by; `chosen` are those of Splatting::normalized.
SplatScales scales_of(Splatting splatting, const SplatScales& chosen);

/// Where the surfels are in the picture.
struct SplatPlace {
  PixelRect region;     ///< holds all of them, enlarged as they are drawn
  float radius = 0.0f;  ///< of one on average, not enlarged, in pixels
};

/// Draws surfels: paper 2, section V-B, with ERRATA 9 to 11.
class Splatter {
 public:
  Splatter();

  /// For pictures of this size: `color` is encoded as sRGB when it is written. Both textures stay
  /// the caller's, until the next call.
  Result<void> resize(glm::ivec2 size, const gl::Texture& color, const gl::Texture& depth);

  /// Into the textures of `resize`, which are cleared: linear colours, and 1 where something was
  /// drawn, less where blending left it transparent. fill_holes: Splatting::normalized reconstructs
  /// what is missing (reconstruction.h). Depth writes and the depth test (GL_GREATER) are on,
  /// blending off, and so they are left. The depth is that of what is seen, for one pixel of it or
  /// another: splats are pushed back by up to a radius, and rims are not all in it.
  Result<void> draw(InstancingMethod& method, const InstanceBuffer& instances, Splatting splatting,
                    const SplatScales& scales, bool fill_holes, const SplatPlace& place);

  /// Of weighted colours and of weights, of the last picture by Splatting::normalized.
  const gl::Texture& sums() const { return sums_; }

 private:
  Result<void> draw_passes(InstancingMethod& method, const InstanceBuffer& instances,
                           Splatting splatting, const SplatScales& scales, bool fill_holes,
                           const SplatPlace& place);
  Result<void> draw_blended(InstancingMethod& method, const InstanceBuffer& instances,
                            float scale) const;
  Result<void> draw_normalized(InstancingMethod& method, const InstanceBuffer& instances,
                               float scale, bool fill_holes, const SplatPlace& place);

  gl::LateProgram resolve_;
  gl::Texture sums_;
  PixelRect summed_;          ///< outside of it they are 0
  GLuint depth_ = 0;          ///< the caller's
  gl::Framebuffer splats_;    ///< sums and depth
  gl::Framebuffer picture_;   ///< colour and depth
  gl::Framebuffer resolved_;  ///< colour alone: the depth is read
  Reconstruction reconstruction_;
  gl::VertexArray no_attributes_ = gl::VertexArray::create();
};

}  // namespace pointreel
