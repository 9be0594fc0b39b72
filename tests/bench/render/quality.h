#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "client/render/opengl/gl_renderer.h"
#include "tests/bench/render/image_error.h"
#include "tests/bench/render/scenes.h"
#include "tests/bench/render/viewpoints.h"

namespace pointreel::bench {

/// One of the ways to draw that are compared.
struct PictureSetting {
  std::string name;
  DrawOptions options;
  bool papers = false;  ///< from Slomp et al., Geometry Instancing, Figure 3
};

/// The default, then all other ways to splat, then voxels and points.
std::vector<PictureSetting> picture_settings();

/// The frame of the scene that is drawn in this mode.
const std::shared_ptr<const SceneFrame>& frame_of(const RenderScene& scene, DrawMode mode);

struct DrawnPicture {
  Image image;
  Mask covered;  ///< not 0 where anything was drawn
  DrawStats stats;
};
Result<DrawnPicture> draw_picture(Renderer& renderer, std::shared_ptr<const SceneFrame> frame,
                                  const Camera& camera, glm::ivec2 size,
                                  const DrawOptions& options);

/// PSNR and SSIM over the figure and over the whole picture, holes, dilation and IoU.
nlohmann::json picture_errors(const TruthPicture& truth, const DrawnPicture& picture);

/// A view of a scene, with everything that all settings share.
struct ViewTruth {
  Viewpoint view;
  TruthPicture truth;
  std::shared_ptr<const SceneFrame> labelled;  ///< for measuring the bleed
};
ViewTruth make_view_truth(const RenderScene& scene, const Viewpoint& view, glm::ivec2 size);

/// All figures of a setting in a view, for the report, and the picture that was measured.
struct Quality {
  nlohmann::json row;
  Image image;
};
/// With `whole`, also measures bleed, the influence of the order of the points, and flicker, which
/// takes four more pictures.
Result<Quality> measure_quality(Renderer& renderer, const RenderScene& scene, const ViewTruth& view,
                                const PictureSetting& setting, bool whole);

/// The truth, the picture and four times their difference side by side, each at half its size.
Image side_by_side(const Image& truth, const Image& picture);

}  // namespace pointreel::bench
