#pragma once

#include <memory>
#include <optional>

#include <glm/glm.hpp>

#include "client/render/renderer.h"
#include "client/scene/camera.h"
#include "client/scene/frame.h"
#include "client/ui/timeline.h"

namespace pointreel {

/// Small pictures of frames, as points, for the timeline. Needs the OpenGL context that was current
/// when the first one was drawn.
class ThumbnailPainter {
 public:
  /// `scale`: the interface's.
  explicit ThumbnailPainter(float scale) : scale_(scale) {}

  /// From the camera's side, with all of `bounds` in the picture. Nothing if it cannot be drawn;
  /// the same as before for the same frame and camera.
  std::optional<Thumbnail> draw(const PlacedFrame& frame, const Box& bounds, const Camera& camera,
                                const glm::vec3& background);

 private:
  const float scale_;
  std::optional<Renderer> renderer_;
  bool failed_ = false;
  PlacedFrame frame_;
  Camera camera_;
};

}  // namespace pointreel
