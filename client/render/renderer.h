#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <glm/glm.hpp>

#include "client/render/image.h"
#include "client/scene/camera.h"
#include "client/scene/draw_options.h"
#include "client/scene/draw_stats.h"
#include "client/scene/frame.h"
#include "pointreel/error.h"

namespace pointreel {

/// Draws scenes into a picture of its own: as points, as surfels by splatting, as voxels, or as
/// triangle strips.
/// Colours come in and go out as sRGB; lighting and blending happen in linear light, with sums in
/// 32-bit float. Depth is reversed, in 32-bit float.
class Renderer {
 public:
  virtual ~Renderer() = default;

  /// What draws, for people: "OpenGL 4.5 ... on llvmpipe (...)".
  virtual std::string describe() const = 0;

  /// Draws `scene` as a picture of `size` pixels, each above 0, and waits until it is complete. An
  /// empty scene shows only the background. Shares ownership of the frames until the next call:
  /// instances are made again only if the scene or its style changes, those of trees also if the
  /// camera or the size changes. Fails with ErrorCode::argument for sizes that cannot be drawn, and
  /// with ErrorCode::limit if there is too little memory.
  virtual Result<DrawStats> draw(const Scene& scene, const Camera& camera, glm::ivec2 size,
                                 const DrawOptions& options) = 0;
  /// Draws a scene of one frame, in the coordinates of that frame.
  Result<DrawStats> draw(std::shared_ptr<const SceneFrame> frame, const Camera& camera,
                         glm::ivec2 size, const DrawOptions& options) {
    return draw(Scene{{std::move(frame)}}, camera, size, options);
  }

  /// Copies the last picture into a framebuffer of the current OpenGL context (0 for that of the
  /// window), in the size that was passed to draw(). The lower left corners coincide; the rest of
  /// the framebuffer becomes background.
  virtual void present(unsigned framebuffer) = 0;

  /// The last picture as an opaque RGBA8 texture of the current OpenGL context, with linear
  /// filtering, whose first row is the lowest. Its bytes are sRGB, for code that draws without
  /// converting colours (Dear ImGui). 0 before the first picture; the texture changes with the
  /// size.
  virtual unsigned texture() = 0;

  /// The position in the world of what the last picture shows at `pixel`, counted from the upper
  /// left corner of the picture as it is shown. If that pixel shows only background or floor, the
  /// nearest one that shows more is taken, up to a few pixels away. Empty if there is none. The
  /// position of a surfel may be too far away by up to its radius.
  virtual std::optional<glm::dvec3> point_at(const glm::dvec2& pixel) const = 0;

  /// Reads the last picture. Fails with ErrorCode::not_found before the first one.
  virtual Result<Image> read_pixels() const = 0;
};

}  // namespace pointreel
