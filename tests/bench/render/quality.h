#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "client/render/renderer.h"
#include "tests/bench/render/image_error.h"
#include "tests/bench/render/scenes.h"
#include "tests/bench/render/viewpoints.h"

namespace pointreel::bench {

/// A way to draw, of those that are compared.
struct PictureSetting {
  std::string name;
  DrawOptions options;
  bool papers = false;  ///< one of paper 2, Figure 3
};

/// Every way to splat, the default first; voxels and points.
std::vector<PictureSetting> picture_settings();

/// What of the scene is drawn in this mode.
const std::shared_ptr<const SceneFrame>& frame_of(const RenderScene& scene, DrawMode mode);

struct DrawnPicture {
  Image image;
  Mask covered;  ///< not zero where anything was drawn
  DrawStats stats;
};
Result<DrawnPicture> draw_picture(Renderer& renderer, std::shared_ptr<const SceneFrame> frame,
                                  const Camera& camera, glm::ivec2 size,
                                  const DrawOptions& options);

/// One view of a scene: what is the same for all settings.
struct ViewTruth {
  Viewpoint view;
  TruthPicture truth;
  std::shared_ptr<const SceneFrame> labelled;  ///< for the bleed
};
ViewTruth make_view_truth(const RenderScene& scene, const Viewpoint& view, glm::ivec2 size);

/// Every figure of a setting in a view, for the report; and the picture that they are of.
struct Quality {
  nlohmann::json row;
  Image image;
};
/// `whole`: how much the order of the points matters and whether it flickers as well, for three
/// more pictures.
Result<Quality> measure_quality(Renderer& renderer, const RenderScene& scene, const ViewTruth& view,
                                const PictureSetting& setting, bool whole);

/// Truth, picture and four times their difference beside each other, each at half its size.
Image side_by_side(const Image& truth, const Image& picture);

}  // namespace pointreel::bench
