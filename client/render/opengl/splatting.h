#pragma once

#include <cstdint>
#include <functional>

#include <glm/glm.hpp>

#include "client/render/opengl/gl_objects.h"
#include "client/render/opengl/instancing/method.h"
#include "client/render/opengl/late_light.h"
#include "client/render/opengl/reconstruction.h"
#include "client/render/opengl/strip_passes.h"
#include "client/render/region.h"
#include "client/scene/draw_options.h"

namespace pointreel {

/// The surfels of a picture, all together.
struct SplatPlace {
  PixelRect region;               ///< contains all surfels at the size at which they are drawn
  float radius = 0.0f;            ///< mean radius, not enlarged
  float pixels = 0.0f;            ///< the same in pixels
  float nearest = 0.0f;           ///< no surfel has a smaller depth; > 0
  bool signs_unknown = false;     ///< normals may point to either side of the surface
  std::uint32_t one_back_in = 1;  ///< SceneInstances::one_back_in
};

/// Lights pixels once they are known.
struct SplatLight {
  LateLight& light;
  /// Makes methods of instancing draw normals in place of colours.
  std::function<void()> show_normals;
};

/// Draws surfels: Slomp et al., Geometry Instancing, section V-B, corrected as FORMULAS.md says
/// under "Two-pass depth tolerance", "Order-independent blending" and "Splat scales".
class Splatter {
 public:
  Splatter();

  /// Sets the size and the textures of the pictures to come. `color` is encoded as sRGB when it is
  /// written. The caller owns both textures and keeps them until the next call.
  Result<void> resize(glm::ivec2 size, const gl::Texture& color, const gl::Texture& depth);

  /// Draws into the textures given to `resize`, which the caller has cleared. Colours are linear;
  /// alpha is 1 where something was drawn, and less where blending left it transparent. With
  /// `fill_holes`, Splatting::normalized fills the holes of surfaces (reconstruction.h). On entry
  /// and on return, depth writes and the depth test (GL_GREATER) are on and blending is off. The
  /// depths are approximate: splats are pushed back by up to their radius, and their rims may be
  /// missing. With `late`, pixels are lit once they are known; then `splatting` is
  /// Splatting::normalized.
  Result<void> draw(InstancingMethod& method, const InstanceBuffer& instances, Splatting splatting,
                    const SplatScales& scales, bool fill_holes, const SplatPlace& place,
                    const SplatLight* late);

  /// Draws voxels or points, which `draw_elements` draws into the bound framebuffer, and lights
  /// their pixels.
  Result<void> draw_lit(const std::function<Result<void>()>& draw_elements, const SplatLight& late,
                        const PixelRect& region);

  /// Draws strips, whose pixels need no blending, into the same textures, and fills holes by the
  /// same rules. `points` draws the representative surfels of the strips. The state on entry and on
  /// return is as for `draw`; faces are not culled.
  Result<void> draw_strips(StripPasses& strips, const InstanceBuffer& vertices,
                           const std::function<Result<void>()>& points, bool fill_holes,
                           const SplatPlace& place, const SplatLight* late);

  /// The sums of weighted colours (rgb) and of weights (alpha) of the last picture that was drawn
  /// with Splatting::normalized.
  const gl::Texture& sums() const { return sums_; }

 private:
  Result<void> draw_passes(InstancingMethod& method, const InstanceBuffer& instances,
                           Splatting splatting, const SplatScales& scales, bool fill_holes,
                           const SplatPlace& place, const SplatLight* late);
  Result<void> draw_blended(InstancingMethod& method, const InstanceBuffer& instances,
                            float scale) const;
  Result<void> draw_normalized(InstancingMethod& method, const InstanceBuffer& instances,
                               float scale, bool fill_holes, const SplatPlace& place,
                               const SplatLight* late);
  void clear_sums(const PixelRect& region);
  /// Makes the picture of the sums. Depth test and blending are off.
  Result<void> finish(bool fill_holes, const SplatPlace& place, const SplatLight* late);
  /// Writes the colours of sums into the picture.
  Result<void> resolve(const gl::Texture& sums, const Reconstruction::Filling* filling,
                       const PixelRect& region);

  gl::LateProgram resolve_;
  gl::Texture sums_;
  PixelRect summed_;           ///< outside of it the sums are 0
  GLuint depth_ = 0;           ///< the caller owns it
  gl::Framebuffer splats_;     ///< sums and depth
  gl::Framebuffer only_sums_;  ///< without depth, which a shader reads
  gl::Framebuffer picture_;    ///< colour and depth
  gl::Framebuffer resolved_;   ///< colour without depth, which the shader reads
  Reconstruction reconstruction_;
  gl::VertexArray no_attributes_ = gl::VertexArray::create();
};

}  // namespace pointreel
