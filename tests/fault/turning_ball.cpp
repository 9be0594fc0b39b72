#include "tests/fault/turning_ball.h"

#include <cmath>

namespace pointreel {

PointCloud turning_ball(int frame) {
  constexpr int kPoints = 1500;
  PointCloud cloud;
  for (int i = 0; i < kPoints; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / kPoints;
    const double angle = 2.399963 * i + 0.01 * frame;
    const double r = std::sqrt(1.0 - z * z);
    cloud.positions.push_back(glm::vec3(r * std::cos(angle), r * std::sin(angle), z));
    cloud.colors.push_back(glm::u16vec3(257 * (i % 256), 257 * (frame % 256), 257 * 200));
  }
  return cloud;
}

}  // namespace pointreel
