#pragma once

#include <memory>
#include <optional>

#include <glm/glm.hpp>

#include "client/render/renderer.h"
#include "client/scene/camera.h"
#include "client/scene/frame.h"
#include "client/scene/renderer_choice.h"
#include "client/ui/timeline.h"

namespace pointreel {

/// Draws small pictures of frames, as points, for the timeline. Needs the OpenGL context that was
/// current when the first one was drawn.
class ThumbnailPainter {
 public:
  /// Looks in the direction of the camera at all of `bounds`. Nothing if it cannot be drawn. The
  /// last picture is kept for as long as nothing changes. `scale` is that of the interface.
  std::optional<Thumbnail> draw(const PlacedFrame& frame, const Box& bounds, const Camera& camera,
                                const glm::vec3& background, RendererChoice choice, float scale);

 private:
  RendererChoice choice_ = RendererChoice::automatic;  ///< of renderer_
  std::unique_ptr<Renderer> renderer_;
  bool failed_ = false;
  PlacedFrame frame_;
  Camera camera_;
  float scale_ = 0.0f;
};

}  // namespace pointreel
