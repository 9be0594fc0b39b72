#include "tests/bench/render/viewpoints.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "datasets_synthetic/sdf.h"

namespace pointreel::bench {
namespace {

struct Wanted {
  const char* name;
  Bone target;
  double yaw, pitch, coverage;
};
constexpr std::array<Wanted, 4> kWanted = {{
    {"front", Bone::abdomen, 0.0, 0.1, 0.28},
    {"left", Bone::chest, 1.05, 0.2, 0.45},
    {"back", Bone::abdomen, 2.8, 0.05, 0.62},
    {"close-up", Bone::chest, -0.6, 0.15, 0.80},
}};

constexpr double kNearest = 0.3, kFarthest = 8.0;  // metres
constexpr int kHalvings = 9;                       // bisects the distance to 0.6 %
constexpr int kCoarseWidth = 120;

}  // namespace

std::vector<Viewpoint> viewpoints(const TruthScene& scene, glm::ivec2 size, int count) {
  const glm::ivec2 coarse(kCoarseWidth, std::max(1, kCoarseWidth * size.y / size.x));
  const Box box = bounds(scene.body.surface);
  std::vector<Viewpoint> views;
  for (const Wanted& wanted : kWanted) {
    if (static_cast<int>(views.size()) >= count) break;
    Camera camera;
    camera.frame_bounds(box, static_cast<double>(size.x) / size.y);
    camera.target = scene.body.frames[static_cast<std::size_t>(wanted.target)].joint;
    camera.yaw = wanted.yaw;
    camera.pitch = wanted.pitch;
    double near = kNearest, far = kFarthest;
    for (int i = 0; i < kHalvings; ++i) {
      camera.distance = std::sqrt(near * far);
      (truth_coverage(scene, camera, coarse) > wanted.coverage ? near : far) = camera.distance;
    }
    views.push_back({wanted.name, camera, wanted.coverage});
  }
  return views;
}

}  // namespace pointreel::bench
