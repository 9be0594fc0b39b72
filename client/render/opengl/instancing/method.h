#pragma once

#include "client/render/opengl/instance_buffer.h"
#include "pointreel/error.h"

namespace pointreel {

/// What instances are drawn as. Each pass has programs of its own.
enum class Pass {
  surfel_depth,  ///< discs: only depth, for visibility splatting
  surfel_sum,    ///< discs: sums of weighted colours and of weights
  surfel_blend,  ///< discs: colours with the mask as opacity
  voxel_cube,    ///< whole cubes: the paper's template, a strip of 14 vertices
  voxel_faces,   ///< the three faces of a cube that the eye can see
};

inline constexpr std::size_t kPasses = 5;

struct PassParameters {
  float scale = 1.0f;  ///< factor for the radii of surfels
  /// How far surfels are moved away from the eye, in scaled radii, without moving in the picture.
  /// FORMULAS.md, "Two-pass depth tolerance".
  float tolerance = 0.0f;
};

/// A way to draw instances: Slomp et al., Geometry Instancing, section IV. All methods draw the
/// same picture; they differ in how instances reach the shaders. The caller sets the framebuffer,
/// blending, the depth test and the View block of common.glsl.
class InstancingMethod {
 public:
  virtual ~InstancingMethod() = default;

  /// Begins a picture, after the View block was set: view and instances may have changed. No pass
  /// will have a scale above `largest_scale`.
  virtual void begin(float largest_scale) { static_cast<void>(largest_scale); }
  /// Draws all instances. Compiles the programs when they are first needed, and fails as
  /// gl::make_program does.
  virtual Result<void> draw(const InstanceBuffer& instances, Pass pass,
                            const PassParameters& parameters) = 0;
};

}  // namespace pointreel
