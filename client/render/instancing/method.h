#pragma once

#include "client/render/instance_buffer.h"
#include "pointreel/error.h"

namespace pointreel {

/// What instances are drawn as; each is a program of its own.
enum class Pass {
  surfel_depth,  ///< discs, depth alone: visibility splatting
  surfel_sum,    ///< discs, sums of weighted colours and of weights
  surfel_blend,  ///< discs, colours with the mask as their opacity
  voxel_cube,    ///< whole cubes: the paper's template, as a strip of 14 vertices
  voxel_faces,   ///< the three faces of a cube that the eye can see
};

inline constexpr std::size_t kPasses = 5;

struct PassParameters {
  float scale = 1.0f;  ///< by which the radii of surfels are multiplied
  /// How far surfels are moved away from the eye, in scaled radii; their place in the picture stays
  /// (ERRATA 9).
  float tolerance = 0.0f;
};

/// One way to draw instances: paper 2, section IV. Every method draws the same picture; they differ
/// in how instances reach the shaders. Framebuffer, blending, depth test and the View block of
/// common.glsl are the caller's.
class InstancingMethod {
 public:
  virtual ~InstancingMethod() = default;

  /// Before the passes of a picture, whose View block is set: view and instances may have changed.
  /// No pass will have a scale above `largest_scale`.
  virtual void begin(float largest_scale) { static_cast<void>(largest_scale); }
  /// Draws all instances. Programs are compiled when they are first needed: the error is a
  /// compiler's.
  virtual Result<void> draw(const InstanceBuffer& instances, Pass pass,
                            const PassParameters& parameters) = 0;
};

}  // namespace pointreel
