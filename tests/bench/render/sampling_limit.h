#pragma once

#include <optional>

#include "tests/bench/render/quality.h"

namespace pointreel::bench {

/// The best PSNR over the pixels of the truth that the points of a scene without noise allow. The
/// truth decides which surface a pixel shows, and the colour is the Gaussian mean of the points
/// around it, lit like surfels, with a standard deviation of 0.4 spacings (the best value that was
/// tried). What remains is the error of the sampling: edges of colours, and folds that are finer
/// than the points. Any error beyond that is the renderer's. Evaluates one pixel in nine.
std::optional<double> sampling_limit(const RenderScene& scene, const ViewTruth& view);

}  // namespace pointreel::bench
