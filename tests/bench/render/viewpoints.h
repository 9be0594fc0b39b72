#pragma once

#include <string>
#include <vector>

#include "client/scene/camera.h"
#include "tests/bench/render/truth.h"

namespace pointreel::bench {

struct Viewpoint {
  std::string name;
  Camera camera;
  double coverage;  ///< share of the picture that the figure should cover
};

/// The first `count` (at most 4) of the viewpoints around the figure, from one that shows most of
/// it to a close-up. Their distances make the figure cover 28, 45, 62 and 80 % of a picture of this
/// size, to within a few percent. Slomp et al., Geometry Instancing, section VII has 25 to 85 %.
std::vector<Viewpoint> viewpoints(const TruthScene& scene, glm::ivec2 size, int count = 4);

}  // namespace pointreel::bench
