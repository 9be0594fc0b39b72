#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/light_probe.h"
#include "client/render/opengl/eye_dome_lighting.h"
#include "client/render/opengl/floor.h"
#include "client/render/opengl/gl_context.h"
#include "client/render/opengl/gl_objects.h"
#include "client/render/opengl/instance_buffer.h"
#include "client/render/opengl/instancing/instancing.h"
#include "client/render/opengl/late_light.h"
#include "client/render/opengl/outlines.h"
#include "client/render/opengl/splatting.h"
#include "client/render/opengl/strip_passes.h"
#include "client/render/region.h"
#include "client/render/renderer.h"
#include "client/render/scene_instances.h"
#include "client/render/scene_strips.h"
#include "client/render/view.h"
#include "common/threads/tbb_executor.h"

namespace pointreel {

/// Draws scenes with OpenGL 4.5 into a framebuffer of its own. Surfels and voxels are drawn with
/// any of the methods of instancing (Slomp et al., Geometry Instancing, section IV).
///
/// Needs the same current context from construction to destruction, whether of a window or
/// offscreen. Sets all OpenGL state that it depends on, and restores none.
class GlRenderer final : public Renderer {
 public:
  /// Fails with ErrorCode::unsupported if the context has an older OpenGL. Cheap: programs are
  /// compiled when a picture first needs them.
  static Result<GlRenderer> create();

  std::string describe() const override { return describe_opengl(); }
  using Renderer::draw;
  /// Fails also with ErrorCode::unsupported if the driver rejects a program.
  Result<DrawStats> draw(const Scene& scene, const Camera& camera, glm::ivec2 size,
                         const DrawOptions& options) override;
  void present(unsigned framebuffer) override;
  unsigned texture() override { return view_.name(); }
  std::optional<glm::dvec3> point_at(const glm::dvec2& pixel) const override;
  Result<Image> read_pixels() const override;

 private:
  GlRenderer();
  Result<void> resize(glm::ivec2 size);
  InstancingMethod& method_for(Instancing instancing);
  void set_view(const PictureView& view) const;
  /// `view` and `region` are those of the instances.
  Result<void> draw_instances(const PictureView& view, const PixelRect& region,
                              const DrawOptions& options);
  Result<void> draw_surfels(const PictureView& view, const PixelRect& region,
                            const DrawOptions& options);
  /// These two draw into the bound framebuffer.
  Result<void> draw_voxels(const DrawOptions& options);
  Result<void> draw_strips(const PictureView& view, const PixelRect& region,
                           const DrawOptions& options, const SplatLight* late);
  Result<void> draw_points(const DrawOptions& options);
  /// Into the bound framebuffer; sizes as in point.vert.glsl.
  Result<void> draw_points(const InstanceBuffer& points, float least, float largest);
  SplatPlace splat_place(const PictureView& view, const PixelRect& region) const;
  Result<void> draw_floor(const FloorGrid& grid, const Camera& camera, const DrawOptions& options);

  /// By the number of the method, made when first used.
  std::array<std::unique_ptr<InstancingMethod>, kEnumNames<Instancing>.size()> methods_;
  Splatter splatter_;
  LightProbes probes_;
  LateLight late_light_;
  EyeDomeLighting eye_dome_;
  OutlineSmoother outlines_;
  Floor floor_;
  gl::LateProgram point_;
  gl::VertexArray points_;
  gl::Buffer view_buffer_;
  gl::Texture color_, depth_, view_;
  gl::Framebuffer picture_;
  // The last picture:
  glm::ivec2 size_{0};   ///< in which it was drawn
  glm::ivec2 shown_{0};  ///< in which it is shown
  Camera camera_;
  glm::vec3 background_{0.0f};
  PixelRect drawn_on_;  ///< the rest of the picture is background
  SceneInstances instances_{tbb_executor()};
  InstanceBuffer buffer_;
  SceneStrips strips_;
  StripPasses strip_passes_;
};

}  // namespace pointreel
