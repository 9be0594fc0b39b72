#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <glm/glm.hpp>

#include "client/render/renderer.h"
#include "client/scene/camera.h"
#include "client/scene/frame.h"
#include "pointreel/error.h"

namespace pointreel {

/// Draws scenes and writes pictures of them. Needs the renderer's OpenGL context, if it has one.
class Painter {
 public:
  /// Pictures that are written are drawn `supersample` times as wide and high, and averaged.
  Painter(std::unique_ptr<Renderer> renderer, int supersample)
      : renderer_(std::move(renderer)), supersample_(supersample) {}

  std::string describe_renderer() const { return renderer_->describe(); }

  Result<DrawStats> draw(const Scene& scene, const Camera& camera, glm::ivec2 size,
                         const DrawOptions& options, const DraftCoarsening& coarsening = {});
  /// Copies the last picture into the window's framebuffer.
  void present() const { renderer_->present(0); }
  /// As Renderer::point_at, in the last picture.
  std::optional<glm::dvec3> point_at(const glm::dvec2& pixel) const {
    return renderer_->point_at(pixel);
  }
  /// The last picture as it is written, never coarser than asked, with a legend if a scalar field
  /// is shown.
  Result<Image> picture();
  /// Writes it as a PNG file.
  Result<void> write(const std::string& path);

 private:
  Result<Image> plain_picture();

  std::unique_ptr<Renderer> renderer_;
  int supersample_;
  // Of the last picture.
  Scene scene_;
  Camera camera_;
  glm::ivec2 size_{0};
  DrawOptions options_;
  DraftCoarsening coarsening_;
};

}  // namespace pointreel
