#include "client/bindings/python/picture.h"

#include <cmath>
#include <memory>
#include <utility>

#include "client/prepare/prepare.h"
#include "client/render/software/software_renderer.h"
#include "client/scene/camera.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"
#include "common/threads/tbb_executor.h"

namespace pointreel {
namespace {

constexpr int kMostPixels = 16384;  ///< of a side

Result<void> check(const PictureOptions& options) {
  for (const int side : {options.size.x, options.size.y})
    if (side < 1 || side > kMostPixels)
      return fail(ErrorCode::argument, "width and height are 1 to 16384 pixels");
  if (!(options.zoom > 0.0) || !std::isfinite(options.zoom))
    return fail(ErrorCode::argument, "zoom is above 0");
  if (options.view && !(std::isfinite(options.view->x) && std::abs(options.view->y) <= 90.0))
    return fail(ErrorCode::argument, "a view is a yaw, and a pitch of -90 to 90 degrees");
  return {};
}

}  // namespace

Result<Image> picture_of(const PointFrame& frame, const PictureOptions& options) {
  TRY(check(options));
  return or_out_of_memory([&]() -> Result<Image> {
    PrepareOptions prepare;
    prepare.mode = options.mode;
    auto scene =
        std::make_shared<SceneFrame>(TRY(prepare_frame(frame.fetched, frame.info, prepare)));
    const FrameBoxes& boxes = scene->boxes;
    const Box box = !options.box.empty()  ? options.box
                    : !boxes.main.empty() ? boxes.main
                                          : boxes.all;
    Camera camera;
    camera.up = options.up;
    camera.frame_bounds(box, static_cast<double>(options.size.x) / options.size.y);
    if (options.view) {
      const glm::dvec2 radians = glm::radians(*options.view);
      camera.yaw = camera.pitch = 0.0;
      camera.orbit(radians.x, radians.y);
    }
    camera.zoom(1.0 / options.zoom);
    DrawOptions draw;
    draw.mode = options.mode;
    draw.refine = true;
    draw.smooth_outlines = true;
    draw.background = options.background;
    SoftwareRenderer renderer(tbb_executor());
    TRY(renderer.draw(std::move(scene), camera, options.size, draw));
    return renderer.read_pixels();
  });
}

}  // namespace pointreel
