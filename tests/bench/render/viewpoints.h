#pragma once

#include <string>
#include <vector>

#include "client/scene/camera.h"
#include "tests/bench/render/truth.h"

namespace pointreel::bench {

struct Viewpoint {
  std::string name;
  Camera camera;
  double coverage;  ///< share of the picture that the figure is meant to cover
};

/// Around the figure, from one that shows most of it to a close-up: as far away as makes it cover
/// 28, 45, 62 and 80 % of a picture of this size, within a few hundredths. Paper 2, section VII,
/// has 25 to 85 %. The first `count` of them, at most 4.
std::vector<Viewpoint> viewpoints(const TruthScene& scene, glm::ivec2 size, int count = 4);

}  // namespace pointreel::bench
