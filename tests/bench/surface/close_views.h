#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "client/render/opengl/gl_renderer.h"
#include "pointreel/error.h"
#include "tests/bench/surface/measure_frame.h"

namespace pointreel::bench {

/// A picture of the head from 50 cm, drawn in one way.
struct CloseView {
  std::string setting;
  double surfels = 0.0;           ///< new ones
  double first_ms = 0.0;          ///< to divide surfels in the first picture of a frame, the least
  double again_ms = 0.0;          ///< when the camera has moved, the least
  double psnr = 0.0, ssim = 0.0;  ///< over the figure's pixels
  double holes = 0.0, iou = 0.0;
};

/// Cleans the frame with auto, and draws it at 1280x720 with surfels as they are, divided, and
/// divided with smooth outlines. Times are the least of `runs`.
Result<std::vector<CloseView>> measure_close_views(Renderer& renderer, const TrueFrame& frame,
                                                   int runs);

/// The means of the settings, which are the same in each list.
nlohmann::json to_json(const std::vector<std::vector<CloseView>>& all);

/// A table of such means.
std::string close_views_table(const nlohmann::json& rows);

}  // namespace pointreel::bench
