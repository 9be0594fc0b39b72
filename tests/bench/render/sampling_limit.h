#pragma once

#include <optional>

#include "tests/bench/render/quality.h"

namespace pointreel::bench {

/// What the points of a scene without noise can give at best, as the PSNR over the truth's pixels:
/// the truth decides what is visible where, and the colour is the Gaussian mean of the points
/// around, lit as surfels are, with a standard deviation of 0.4 spacings (the best of those that
/// were tried). The rest of a picture's error is the renderer's, this is the sampling's: colours
/// that end at an edge, and folds finer than the points. Of one pixel in nine.
std::optional<double> sampling_limit(const RenderScene& scene, const ViewTruth& view);

}  // namespace pointreel::bench
