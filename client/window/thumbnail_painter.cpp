#include "client/window/thumbnail_painter.h"

#include <utility>

#include "client/render/make_renderer.h"

namespace pointreel {
namespace {

constexpr glm::ivec2 kSize{176, 99};

}  // namespace

std::optional<Thumbnail> ThumbnailPainter::draw(const PlacedFrame& frame, const Box& bounds,
                                                const Camera& camera, const glm::vec3& background,
                                                RendererChoice choice, float scale) {
  if (choice != choice_) {
    choice_ = choice;
    renderer_.reset();
    failed_ = false;
    frame_ = {};
  }
  if (!renderer_ && !failed_) {
    auto renderer = make_window_renderer(choice);
    failed_ = !renderer;
    if (renderer) renderer_ = *std::move(renderer);
  }
  if (!renderer_) return std::nullopt;
  if (frame.frame != frame_.frame || camera != camera_ || scale != scale_) {
    // From the same direction, but far enough away to see everything.
    Camera near = camera;
    near.frame_bounds(bounds, static_cast<double>(kSize.x) / kSize.y);
    near.yaw = camera.yaw;
    near.pitch = camera.pitch;
    DrawOptions options;
    options.mode = DrawMode::point;
    // Nodes are not divided below the size of a point.
    options.point_size = options.pixel_size = 2.0f * scale;
    options.background = background;
    if (!renderer_->draw(Scene{frame}, near, glm::ivec2(glm::vec2(kSize) * scale), options))
      return std::nullopt;
    frame_ = frame;
    camera_ = camera;
    scale_ = scale;
  }
  return Thumbnail{renderer_->texture(), kSize};
}

}  // namespace pointreel
