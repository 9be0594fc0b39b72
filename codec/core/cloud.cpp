#include "pointreel/cloud.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "codec/core/finite.h"
#include "codec/core/keep_points.h"
#include "common/base/characters.h"

namespace pointreel {
namespace {

bool finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Sets unusable radii to zero and returns their number.
std::size_t clear_unusable(std::vector<float>& radii) {
  std::vector<float> usable;
  for (const float r : radii) {
    if (std::isfinite(r) && r > 0.0f) usable.push_back(r);
  }
  float cap = 0.0f;
  if (!usable.empty()) {
    const auto nth =
        usable.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(usable.size() - 1));
    std::nth_element(usable.begin(), nth, usable.end());
    cap = 4.0f * *nth;
  }
  std::size_t unusable = 0;
  for (float& r : radii) {
    if (r > 0.0f && r <= cap) continue;  // false for NaN
    r = 0.0f;
    ++unusable;
  }
  if (unusable == radii.size()) radii.clear();
  return unusable;
}

/// Whether any value is known.
bool clear_infinite(std::vector<float>& values) {
  bool any = false;
  for (float& value : values) {
    if (std::isfinite(value)) {
      any = true;
    } else {
      value = std::numeric_limits<float>::quiet_NaN();
    }
  }
  return any;
}

}  // namespace

bool is_scalar_name(std::string_view name) {
  return !name.empty() && name.size() <= kMaxScalarName && is_harmless(name);
}

Box bounds(const PointCloud& cloud) {
  if (cloud.empty()) return {};
  glm::vec3 low = cloud.positions.front(), high = low;
  for (const glm::vec3& p : cloud.positions) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  return {cloud.origin + glm::dvec3(low), cloud.origin + glm::dvec3(high)};
}

bool colors_fit_8_bits(const PointCloud& cloud) {
  return std::all_of(cloud.colors.begin(), cloud.colors.end(), [](const glm::u16vec3& c) {
    return c.x % 257 == 0 && c.y % 257 == 0 && c.z % 257 == 0;
  });
}

SanitizeReport sanitize(PointCloud& cloud) {
  SanitizeReport report;
  if (!are_finite(cloud.positions)) {
    report.dropped_positions =
        keep_points(cloud, [&](std::size_t i) { return finite(cloud.positions[i]); });
  }

  for (glm::vec3& n : cloud.normals) {
    // In double, so that the square of a tiny component does not vanish and that of a huge one does
    // not overflow.
    const double length = glm::length(glm::dvec3(n));
    if (std::isfinite(length) && length > 0.0) {
      n = glm::vec3(glm::dvec3(n) / length);
    } else {
      n = glm::vec3(0.0f);
      ++report.unknown_normals;
    }
  }
  report.unknown_radii = clear_unusable(cloud.radii);
  std::erase_if(cloud.scalars, [](ScalarField& field) { return !clear_infinite(field.values); });
  return report;
}

}  // namespace pointreel
