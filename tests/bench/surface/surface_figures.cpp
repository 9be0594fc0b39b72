#include "tests/bench/surface/surface_figures.h"

#include <cmath>

namespace pointreel::bench {

SurfaceFigures mean(const std::vector<SurfaceFigures>& all) {
  SurfaceFigures out;
  for (const auto& [key, member] : kSurfaceFigures) {
    double sum = 0.0, count = 0.0;
    for (const SurfaceFigures& figures : all) {
      if (std::isnan(figures.*member)) continue;
      sum += figures.*member;
      ++count;
    }
    out.*member = count > 0.0 ? sum / count : SurfaceFigures::kNone;
  }
  return out;
}

nlohmann::json to_json(const SurfaceFigures& figures) {
  nlohmann::json out;
  for (const auto& [key, member] : kSurfaceFigures) {
    const double value = figures.*member;
    out[key] = std::isnan(value) ? nlohmann::json() : nlohmann::json(value);
  }
  return out;
}

}  // namespace pointreel::bench
