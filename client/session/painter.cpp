#include "client/session/painter.h"

#include <utility>

#include "client/record/numbered_path.h"
#include "client/render/supersampling.h"

namespace pointreel {

Result<std::unique_ptr<Painter>> Painter::create(int supersample) {
  auto renderer = Renderer::create();
  if (!renderer) return tl::unexpected(renderer.error());
  return std::unique_ptr<Painter>(new Painter(*std::move(renderer), supersample));
}

Result<DrawStats> Painter::draw(const Scene& scene, const Camera& camera, glm::ivec2 size,
                                const DrawOptions& options) {
  scene_ = scene;
  camera_ = camera;
  size_ = size;
  options_ = options;
  return renderer_.draw(scene, camera, size, options);
}

Result<Image> Painter::picture() {
  if (reduced()) {
    options_.reduction = 1;
    if (const auto drawn = renderer_.draw(scene_, camera_, size_, options_); !drawn)
      return tl::unexpected(drawn.error());
  }
  auto image = renderer_.read_pixels();
  if (!image) return image;
  if (supersample_ > 1) {
    // Once more, larger, and then as it was.
    DrawOptions larger = options_;
    larger.point_size *= static_cast<float>(supersample_);
    larger.pixel_size *= static_cast<float>(supersample_);
    if (const auto drawn = renderer_.draw(scene_, camera_, supersample_ * size_, larger); !drawn)
      return tl::unexpected(drawn.error());
    const auto large = renderer_.read_pixels();
    if (!large) return tl::unexpected(large.error());
    image = average_squares(*large, supersample_);
    if (const auto drawn = renderer_.draw(scene_, camera_, size_, options_); !drawn)
      return tl::unexpected(drawn.error());
  }
  return image;
}

Result<void> Painter::write(const std::string& path) {
  const auto image = picture();
  if (!image) return tl::unexpected(image.error());
  return write_png(path, *image);
}

}  // namespace pointreel
