#include "datasets_synthetic/samplers/scan_rig.h"

#include <cmath>

#include "datasets_synthetic/trigonometry.h"

namespace pointreel {

double working_distance(const RigOptions& options) {
  const double below = options.low - options.target, above = options.high - options.target;
  const double square = options.radius * options.radius;
  return 0.5 * (std::sqrt(square + below * below) + std::sqrt(square + above * above));
}

Rig make_rig(const RigOptions& options) {
  Rig rig;
  const int count = options.projectors;
  const glm::dvec3 target(0, options.target, 0);
  const auto place = [&](double step, bool high) {
    const double angle = 2.0 * kPi * step / count;
    return look_at({options.radius * sine(angle), high ? options.high : options.low,
                    options.radius * cosine(angle)},
                   target);
  };
  for (int i = 0; i < count; ++i) {
    rig.projectors.push_back(place(i, i % 2 == 0));
    rig.cameras.push_back(place(i + 0.5, i % 2 != 0));
  }
  for (int i = 0; i < count; ++i) {
    const auto own = static_cast<std::size_t>(i);
    const auto before = static_cast<std::size_t>((i + count - 1) % count);
    rig.pairs.push_back({own, own});
    rig.pairs.push_back({own, before});
  }
  return rig;
}

}  // namespace pointreel
