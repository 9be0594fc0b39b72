#include "client/session/painter.h"

#include "client/render/legend_picture.h"
#include "client/render/supersampling.h"
#include "common/base/try.h"

namespace pointreel {

Result<DrawStats> Painter::draw(const Scene& scene, const Camera& camera, glm::ivec2 size,
                                const DrawOptions& options, const DraftCoarsening& coarsening) {
  scene_ = scene;
  camera_ = camera;
  size_ = size;
  options_ = options;
  coarsening_ = coarsening;
  DrawOptions coarser = options;
  coarser.reduction = coarsening.reduction;
  coarser.pixel_size *= coarsening.pixel_size;
  DrawStats stats = TRY(renderer_->draw(scene, camera, size, coarser));
  stats.coarsening = coarsening;
  return stats;
}

Result<Image> Painter::picture() {
  Image image = TRY(plain_picture());
  if (const auto legend = legend_of(scene_)) draw_legend(*legend, image);
  return image;
}

Result<Image> Painter::plain_picture() {
  if (coarsening_ != DraftCoarsening{}) {
    coarsening_ = {};
    TRY(renderer_->draw(scene_, camera_, size_, options_));
  }
  if (supersample_ == 1) return renderer_->read_pixels();
  DrawOptions larger = options_;
  larger.point_size *= static_cast<float>(supersample_);
  larger.pixel_size *= static_cast<float>(supersample_);
  TRY(renderer_->draw(scene_, camera_, supersample_ * size_, larger));
  const Image large = TRY(renderer_->read_pixels());
  // The renderer shows the picture in its own size again.
  TRY(renderer_->draw(scene_, camera_, size_, options_));
  return average_squares(large, supersample_);
}

Result<void> Painter::write(const std::string& path) { return write_png(path, TRY(picture())); }

}  // namespace pointreel
