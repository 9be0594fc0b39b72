#pragma once

#include <memory>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "client/render/renderer.h"
#include "client/scene/camera.h"
#include "client/scene/frame.h"
#include "pointreel/error.h"

namespace pointreel {

/// Draws scenes and writes pictures of them. Needs the renderer's OpenGL context.
class Painter {
 public:
  /// Pictures that are written are drawn `supersample` times as wide and high.
  static Result<std::unique_ptr<Painter>> create(int supersample);

  Result<DrawStats> draw(const Scene& scene, const Camera& camera, glm::ivec2 size,
                         const DrawOptions& options);
  /// Into a window's framebuffer.
  void present() const { renderer_.present(0); }
  /// Renderer's, of the last picture: to be shown in a window, and where what it shows is.
  GLuint texture() const { return renderer_.texture(); }
  std::optional<glm::dvec3> point_at(const glm::dvec2& pixel_from_upper_left) const {
    return renderer_.point_at(pixel_from_upper_left);
  }
  /// Whether the last picture was drawn smaller than it is shown (DrawOptions::reduction).
  bool reduced() const { return options_.reduction > 1; }
  /// What was drawn last, as it is written: never reduced.
  Result<Image> picture();
  /// Writes it as a PNG file.
  Result<void> write(const std::string& path);

 private:
  explicit Painter(Renderer renderer, int supersample)
      : renderer_(std::move(renderer)), supersample_(supersample) {}

  Renderer renderer_;
  const int supersample_;
  // Of the last picture.
  Scene scene_;
  Camera camera_;
  glm::ivec2 size_{0};
  DrawOptions options_;
};

}  // namespace pointreel
