#pragma once

#include <glm/glm.hpp>

#include "client/render/light_probe.h"
#include "client/render/opengl/gl_objects.h"
#include "client/render/opengl/instance_buffer.h"
#include "client/render/shading.h"

namespace pointreel {

/// Lights the pixels of a picture once it is known what they show: Pfister et al., Surfels, section
/// 7.5. The formulas are those of render/software/screen_shading.h.
class LateLight {
 public:
  LateLight();

  /// Begins a picture: draws what the key light sees. `depth` is that of the picture; the caller
  /// keeps it. Changes the viewport, the bound framebuffer and the depth test.
  Result<void> begin(glm::ivec2 size, const gl::Texture& depth, const ShadingView& shading,
                     const LightProbe& probe, const InstanceBuffer& instances);

  /// Darkens the bound framebuffer where it shows the floor in the shadow of the scene. Depth test
  /// and blending are off afterwards.
  Result<void> shade_floor();

  /// The framebuffer of sums of 0.5 + 0.5 n, for normals n, and of weights, with the picture's
  /// depth.
  const gl::Framebuffer& normals() const { return normals_and_depth_; }

  /// Lights the sums of colours and weights of a picture whose normals were drawn. Depth test and
  /// blending must be off. Returns lit sums, which this object owns.
  Result<const gl::Texture*> light(const gl::Texture& sums);

 private:
  Result<void> resize(glm::ivec2 size, const gl::Texture& depth);
  Result<void> draw_shadow(const InstanceBuffer& instances);

  gl::LateProgram shadow_program_, blur_, floor_, open_program_, light_;
  glm::ivec2 size_{0};
  GLuint depth_ = 0;  ///< the caller owns it
  gl::Texture normals_, open_, lit_, glossy_;
  gl::Framebuffer normals_and_depth_, to_open_, to_lit_;
  gl::Texture nearest_, rows_, moments_;  ///< of the key light's map
  gl::Framebuffer to_nearest_, to_rows_, to_moments_;
  gl::Buffer block_ = gl::Buffer::create();
  gl::VertexArray instances_, no_attributes_ = gl::VertexArray::create();
};

}  // namespace pointreel
