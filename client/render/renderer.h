#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/eye_dome_lighting.h"
#include "client/render/floor.h"
#include "client/render/gl_objects.h"
#include "client/render/image.h"
#include "client/render/instancing/instancing.h"
#include "client/render/outlines.h"
#include "client/render/region.h"
#include "client/render/scene_instances.h"
#include "client/render/splatting.h"
#include "client/scene/camera.h"
#include "client/scene/draw_options.h"
#include "client/scene/draw_stats.h"
#include "client/scene/frame.h"

namespace pointreel {

/// Draws scenes into a framebuffer of its own, as points, as surfels by splatting, or as voxels.
/// Surfels and voxels are drawn with any of the methods of instancing (Slomp et al., Geometry
/// Instancing, section IV).
///
/// Needs the same current OpenGL 4.5 context from construction to destruction, whether of a window
/// or offscreen. Sets all OpenGL state that it depends on, and restores none. Depth is reversed, in
/// 32-bit float. Colours come in and go out as sRGB; lighting and blending happen in linear light,
/// with sums in 32-bit float.
class Renderer {
 public:
  /// Fails with ErrorCode::unsupported if the context has an older OpenGL. Cheap: programs are
  /// compiled when a picture first needs them.
  static Result<Renderer> create();

  /// Draws `scene` as a picture of `size` pixels, each above 0, and waits until it is complete. An
  /// empty scene shows only the background. Shares ownership of the frames until the next call:
  /// points are uploaded again only if the scene or its style changes, trees also if the camera or
  /// the size changes. Fails with ErrorCode::argument for sizes that the driver cannot draw,
  /// ErrorCode::limit if its memory does not suffice, and ErrorCode::unsupported if it rejects a
  /// program.
  Result<DrawStats> draw(const Scene& scene, const Camera& camera, glm::ivec2 size,
                         const DrawOptions& options);
  /// Draws a scene of one frame, in the coordinates of that frame.
  Result<DrawStats> draw(std::shared_ptr<const SceneFrame> frame, const Camera& camera,
                         glm::ivec2 size, const DrawOptions& options);

  /// Copies the last picture into a framebuffer (0 for that of the window), in the size that was
  /// passed to draw(). The lower left corners coincide; the rest of the framebuffer becomes
  /// background.
  void present(GLuint framebuffer) const;

  /// The last picture as an opaque GL_RGBA8 texture with linear filtering, whose first row is the
  /// lowest. Its bytes are sRGB, for code that draws without converting colours (Dear ImGui). 0
  /// before the first picture; the texture changes with the size.
  GLuint texture() const { return view_.name(); }

  /// The position in the world of what the last picture shows at `pixel`, counted from the upper
  /// left corner of the picture as it is shown. If that pixel shows only background or floor, the
  /// nearest one that shows more is taken, up to a few pixels away. Empty if there is none. The
  /// position of a surfel may be too far away by up to its radius.
  std::optional<glm::dvec3> point_at(const glm::dvec2& pixel) const;

  /// Reads the last picture. Fails with ErrorCode::not_found before the first one.
  Result<Image> read_pixels() const;

 private:
  /// The View block of common.glsl.
  struct ViewBlock {
    glm::mat4 to_clip;
    glm::vec4 eye;
    glm::vec4 light;
    glm::vec4 pixel;
    glm::vec4 ray_corner, ray_x, ray_y;
    glm::vec4 window;
  };

  Renderer();
  Result<void> resize(glm::ivec2 size);
  InstancingMethod& method_for(Instancing instancing);
  glm::mat4 clip_from(const Camera& camera, const glm::dvec3& origin) const;
  void set_view(const Camera& camera, const glm::dvec3& origin, bool lighting) const;
  /// The part of the picture in which instances may be visible.
  PixelRect instances_region(const DrawOptions& options) const;
  Result<void> draw_instances(const Camera& camera, const DrawOptions& options);
  Result<void> draw_surfels(const Camera& camera, const DrawOptions& options);
  Result<void> draw_voxels(const DrawOptions& options);
  Result<void> draw_points(const DrawOptions& options);
  Result<void> draw_floor(const FloorGrid& grid, const Camera& camera, const DrawOptions& options);

  /// By the number of the method, made when first used.
  std::array<std::unique_ptr<InstancingMethod>, kEnumNames<Instancing>.size()> methods_;
  Splatter splatter_;
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
  SceneInstances instances_;
};

}  // namespace pointreel
