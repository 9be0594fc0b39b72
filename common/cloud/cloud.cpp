#include "pointreel/cloud.h"

#include <algorithm>
#include <cmath>

namespace pointreel {
namespace {

bool finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Moves point `from` to place `to` in every array that the cloud has.
void move_point(PointCloud& cloud, std::size_t from, std::size_t to) {
  cloud.positions[to] = cloud.positions[from];
  if (cloud.has_normals()) cloud.normals[to] = cloud.normals[from];
  if (cloud.has_colors()) cloud.colors[to] = cloud.colors[from];
  if (cloud.has_radii()) cloud.radii[to] = cloud.radii[from];
}

void resize(PointCloud& cloud, std::size_t n) {
  const bool normals = cloud.has_normals(), colors = cloud.has_colors(), radii = cloud.has_radii();
  cloud.positions.resize(n);
  if (normals) cloud.normals.resize(n);
  if (colors) cloud.colors.resize(n);
  if (radii) cloud.radii.resize(n);
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

}  // namespace

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
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!finite(cloud.positions[i])) continue;
    if (kept != i) move_point(cloud, i, kept);
    ++kept;
  }
  report.dropped_positions = cloud.size() - kept;
  resize(cloud, kept);

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
  return report;
}

}  // namespace pointreel
