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
#include "client/render/region.h"
#include "client/render/scene_instances.h"
#include "client/render/splatting.h"
#include "client/scene/camera.h"
#include "client/scene/draw_options.h"
#include "client/scene/draw_stats.h"
#include "client/scene/frame.h"

namespace pointreel {

/// Draws frames into a framebuffer of its own: surfels by splatting, voxels as cubes, both by any
/// of the methods of instancing (paper 2, section IV); points.
///
/// Needs a current OpenGL 4.5 context, always the same one, from construction to destruction, and
/// does not know whether that is a window's. Sets all state that it depends on when it draws, and
/// restores none. Depth is reversed, in 32-bit float. Colours come in and go out as sRGB; lighting
/// and the blending of splats happen in linear light, with 32-bit float sums.
class Renderer {
 public:
  /// Cheap: programs are compiled when a picture first needs them, so that a renderer which only
  /// draws points makes one. The error says that there is not enough OpenGL.
  static Result<Renderer> create();

  /// Draws `scene` (empty: the background alone) as a picture of `size` pixels, both > 0. Keeps
  /// hold of its frames: points are uploaded when scene or mode change, nodes when the cuts do, and
  /// those are used again while scene, camera and size stay as they are.
  Result<DrawStats> draw(const Scene& scene, const Camera& camera, glm::ivec2 size,
                         const DrawOptions& options);
  /// One frame, where it lies.
  Result<DrawStats> draw(std::shared_ptr<const SceneFrame> frame, const Camera& camera,
                         glm::ivec2 size, const DrawOptions& options);

  /// Copies the last picture into a framebuffer, 0 for a window's, in the size that it was to have;
  /// lower left corners coincide, and what is farther out becomes background.
  void present(GLuint framebuffer) const;

  /// The last picture as a texture of GL_RGBA8 whose bytes are sRGB, for what draws without
  /// converting colours (Dear ImGui); opaque, its first row is the lowest, and sampled between
  /// texels. 0 before the first picture; another one when the size changes.
  GLuint texture() const { return view_.name(); }

  /// Where in the world lies what the last picture shows at a pixel, counted from the upper left
  /// corner of what is shown? Nothing where neither that pixel nor any within a few around it shows
  /// more than the background and the floor; else of the pixel that is the nearest to it. Surfels
  /// are taken for up to a radius farther away than they are.
  std::optional<glm::dvec3> point_at(const glm::dvec2& pixel) const;

  /// The last picture; an error before the first one.
  Result<Image> read_pixels() const;
  /// How much of each pixel of the last picture is covered: 0 where nothing was drawn, 255 where
  /// the background does not show. Rows from top to bottom.
  Result<std::vector<std::uint8_t>> read_alpha() const;

 private:
  /// The view of a scene whose zero is the instances' origin; the layout of common.glsl.
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
  /// Where in the picture they can show.
  PixelRect instances_region(const DrawOptions& options) const;
  Result<void> draw_instances(const Camera& camera, const DrawOptions& options);
  Result<void> draw_surfels(const Camera& camera, const DrawOptions& options);
  Result<void> draw_voxels(const DrawOptions& options);
  Result<void> draw_points(const DrawOptions& options);
  Result<void> draw_floor(const FloorGrid& grid, const Camera& camera, const DrawOptions& options);
  Result<std::vector<glm::u8vec4>> read_picture() const;

  std::array<std::unique_ptr<InstancingMethod>, kEnumNames<Instancing>.size()>
      methods_;  ///< made when first used
  Splatter splatter_;
  EyeDomeLighting eye_dome_;
  Floor floor_;
  gl::LateProgram point_;
  gl::VertexArray points_;
  gl::Buffer view_buffer_;
  gl::Texture color_, depth_, view_;
  gl::Framebuffer picture_;
  glm::ivec2 size_{0};   ///< of the picture that was made
  glm::ivec2 shown_{0};  ///< in which it is shown
  // Of the last picture.
  Camera camera_;
  glm::vec3 background_{0.0f};
  PixelRect drawn_on_;  ///< the rest is background
  SceneInstances instances_;
};

}  // namespace pointreel
