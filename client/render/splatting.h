#pragma once

#include <glm/glm.hpp>

#include "client/render/gl_objects.h"
#include "client/render/instancing/method.h"
#include "client/render/region.h"

namespace pointreel {

/// How surfels become a picture. The first five are those of paper 2, Figure 3 (c is the first pass
/// of d), enlarged twice where the paper enlarges.
enum class Splatting {
  regular,           ///< a: one pass, blended in the order of the surfels, with depth
  no_depth,          ///< b: the same without depth
  two_pass,          ///< d: depth first, then blending of what is not behind it
  enlarged,          ///< e: the same, both passes enlarged
  enlarged_shading,  ///< f: the paper's proposal: only the second pass enlarged
  normalized,        ///< depth first, then the weighted mean of what is not behind it, in any order
};

/// "regular", "no-depth", "two-pass", "enlarged", "enlarged-shading", "normalized".
const char* name(Splatting splatting);

struct SplatScales {
  float visibility = 1.0f, shading = 1.0f;

  bool operator==(const SplatScales&) const = default;
};

/// What the passes of a mode multiply radii by; `chosen` are those of Splatting::normalized.
SplatScales scales_of(Splatting splatting, const SplatScales& chosen);

/// Draws surfels: paper 2, section V-B, with ERRATA 9 to 11.
class Splatter {
 public:
  static Result<Splatter> create();

  /// For pictures of this size, whose depths are in `depth`.
  Result<void> resize(glm::ivec2 size, const gl::Texture& depth);

  /// Into a region of the framebuffer `picture` in which all of the surfels lie, and whose colours
  /// are encoded as sRGB when they are written, and whose depth is that of `resize`, cleared;
  /// linear colours, and 1 where something was drawn, less where blending left it transparent.
  /// Depth writes and the depth test are on, blending off, and so they are left.
  void draw(InstancingMethod& method, const InstanceBuffer& instances, Splatting splatting,
            const SplatScales& scales, const PixelRect& region, GLuint picture) const;

 private:
  Splatter() = default;
  void draw_blended(InstancingMethod& method, const InstanceBuffer& instances, float scale,
                    GLuint picture) const;
  void draw_normalized(InstancingMethod& method, const InstanceBuffer& instances, float scale,
                       const PixelRect& region, GLuint picture) const;

  gl::Program resolve_;
  gl::Texture sums_;
  gl::Framebuffer splats_;
  gl::VertexArray no_attributes_;
};

}  // namespace pointreel
