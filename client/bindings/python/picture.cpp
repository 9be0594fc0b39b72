#include "client/bindings/python/picture.h"

#include <cmath>
#include <memory>
#include <utility>

#include "client/render/software/software_renderer.h"
#include "client/scene/camera.h"
#include "codec/core/scalar_fields.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"
#include "common/threads/tbb_executor.h"
#include "pointreel/geometry.h"

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
  if (const auto& range = options.scalar.range;
      range && !(std::isfinite(range->y - range->x) && range->x < range->y))
    return fail(ErrorCode::argument, "color_range is two finite numbers, the smaller first");
  const auto* target = options.target ? std::get_if<glm::dvec3>(&*options.target) : nullptr;
  if (target != nullptr && !std::isfinite(glm::dot(*target, *target)))
    return fail(ErrorCode::argument, "a target is three finite numbers");
  const auto finite = [](const glm::dvec3& at) { return std::isfinite(glm::dot(at, at)); };
  if (const auto& box = options.box; box && !(finite(box->min) && finite(box->max) &&
                                              glm::all(glm::lessThanEqual(box->min, box->max))))
    return fail(ErrorCode::argument, "bounds must be finite, the smallest coordinates first");
  return {};
}

Result<SceneFrame> prepare_points(const PointFrame& frame, const PrepareOptions& options) {
  FrameInfo info = frame.info;
  if (info.scalars.empty()) info.scalars = ranges_of(frame.cloud);
  if (!frame.fetched.file.empty() || !frame.fetched.layers.empty())
    return prepare_frame(frame.fetched, info, options);
  DecodedFrame decoded;
  decoded.cloud = frame.cloud;
  decoded.cube = bounding_cube(bounds(decoded.cloud));
  return prepare_decoded(std::move(decoded), info, options);
}

}  // namespace

Result<Image> picture_of(const PointFrame& frame, const PictureOptions& options) {
  TRY(check(options));
  return or_out_of_memory([&]() -> Result<Image> {
    PrepareOptions prepare;
    prepare.mode = options.mode;
    prepare.scalar = options.scalar;
    prepare.show_normals = options.color == ColorSource::normals;
    auto scene = std::make_shared<SceneFrame>(TRY(prepare_points(frame, prepare)));
    const FrameBoxes& boxes = scene->boxes;
    const Box box = options.box ? *options.box : !boxes.main.empty() ? boxes.main : boxes.all;
    Camera camera;
    camera.up = options.up;
    const double aspect = static_cast<double>(options.size.x) / options.size.y;
    if (options.view) {
      const glm::dvec2 radians = glm::radians(*options.view);
      camera.orbit(radians.x, radians.y);
      camera.fit(box, aspect);
    } else {
      camera.frame_bounds(box, aspect);
    }
    if (options.target) camera.aim_at(*options.target, box);
    camera.zoom(1.0 / options.zoom);
    DrawOptions draw;
    draw.mode = options.mode;
    draw.refine = true;
    draw.smooth_outlines = true;
    draw.background = options.background;
    draw.color = options.color;
    draw.lighting = options.lit;
    draw.light = options.light;
    SoftwareRenderer renderer(tbb_executor());
    TRY(renderer.draw(std::move(scene), camera, options.size, draw));
    return renderer.read_pixels();
  });
}

}  // namespace pointreel
