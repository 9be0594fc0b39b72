#include "client/render/shading.h"

#include <algorithm>
#include <cmath>

namespace pointreel {
namespace {

/// Whether the colours of a source are found for each pixel.
bool is_false_color(ColorSource source) {
  return source == ColorSource::curvature || source == ColorSource::accessibility ||
         source == ColorSource::depth || source == ColorSource::contours;
}

/// A distance between contours that divides this height by about 30: 1, 2 or 5 times a power of
/// ten.
double contour_step(double height) {
  const double least = height / 40.0, power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= least) return factor * power;
  return 10.0 * power;
}

/// The reach of occlusion as a share of the sphere around all instances.
constexpr double kOcclusionReach = 0.09;

}  // namespace

bool is_shaded_late(const DrawOptions& options) {
  return (options.light != Light::flat || is_false_color(options.color)) &&
         (options.mode != DrawMode::surfel || options.splatting == Splatting::normalized);
}

ShadingView make_shading(const DrawOptions& options, const LightProbe& probe, const Camera& camera,
                         const InstanceBounds& bounds, const glm::dvec3& origin) {
  // The axes of somebody who stands upright. The studio turns with the viewer.
  Camera upright = camera;
  upright.pitch = 0.0;
  if (options.light == Light::environment) upright.yaw = 0.0;
  const glm::dmat3 axes = upright.axes();
  const glm::dvec3 up = axes[1], key = glm::normalize(axes * glm::dvec3(probe.key_direction));

  const glm::dvec3 low(bounds.min), high(bounds.max), middle = 0.5 * (low + high);
  const double radius =
      std::max(0.5 * glm::length(high - low) + static_cast<double>(bounds.radius), 1e-30);
  const glm::dvec3 side = glm::normalize(
      glm::cross(std::abs(key.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0), key));
  const glm::dvec3 rows[3] = {side, glm::cross(key, side), key};
  glm::dmat4 to_shadow(1.0);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      to_shadow[column][row] = 0.5 / radius * rows[row][column];
    to_shadow[3][row] = 0.5 - 0.5 / radius * glm::dot(rows[row], middle);
  }
  // The side of the box that is down.
  const double floor = std::min(glm::dot(low, up), glm::dot(high, up));

  ShadingView view{};
  view.to_environment = glm::mat4(glm::mat3(glm::transpose(axes)));
  view.to_shadow = glm::mat4(to_shadow);
  for (std::size_t i = 0; i < 9; ++i) view.diffuse[i] = glm::vec4(probe.diffuse[i], 0.0f);
  const double texel = 2.0 / kShadowEdge;
  view.key_direction =
      glm::vec4(glm::vec3(key), static_cast<float>(1.5 * texel + bounds.mean_radius() / radius));
  view.key = glm::vec4(probe.key, options.roughness);
  view.up = glm::vec4(glm::vec3(up), static_cast<float>(floor));
  view.reach =
      glm::vec4(static_cast<float>(kOcclusionReach * radius), static_cast<float>(radius),
                is_false_color(options.color) ? static_cast<float>(options.color) : 0.0f,
                options.light != Light::flat ? kLateLight : (options.lighting ? 1.0f : 0.0f));
  const double step = contour_step(2.0 * radius);
  const glm::dvec3 back = camera.axes()[2];
  const double depth = glm::dot(camera.eye() - origin - middle, back),
               deep = 0.5 * glm::dot(glm::abs(back), high - low), near = camera.near_plane();
  // Every fifth contour is stronger, so the height may be reduced by five steps.
  view.scale = glm::vec4(static_cast<float>(step),
                         static_cast<float>(std::fmod(glm::dot(origin, up), 5.0 * step)),
                         static_cast<float>(std::max(depth - deep, near)),
                         static_cast<float>(std::max(depth + deep, 2.0 * near)));
  return view;
}

glm::vec2 tap(int i, int turn) {
  // A spiral that covers the disc evenly (H. Vogel, "A better way to construct the sunflower head",
  // 1979). The four turns fill each other's gaps.
  const float away = std::sqrt((static_cast<float>(i) + 0.5f + 0.25f * static_cast<float>(turn)) /
                               (kTaps + 0.75f));
  const float angle = 2.39996323f * static_cast<float>(i) + 0.6f * static_cast<float>(turn);
  return away * glm::vec2(std::cos(angle), std::sin(angle));
}

}  // namespace pointreel
