#include "codec/surface/mean_colors.h"

#include <cmath>

namespace pointreel {
namespace {

/// Colours become means within so many times the root of spacing times noise, unless that is less
/// than so many spacings: then the blending of edges costs as much as is gained.
constexpr float kColorNoiseFactor = 2.8f;
constexpr float kLeastColorSpacings = 1.25f;

}  // namespace

void mean_colors(PointCloud& cloud, const PointSurface& surface,
                 const std::vector<Measured>& measured, std::span<const float> supports,
                 const Executor& executor, std::span<const glm::vec3> normals) {
  const std::span<const KeyIndex> order = surface.order();
  std::vector<float> radii(order.size());
  std::vector<glm::vec3> colors(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const float noise = measured[i].noise, spacing = measured[i].spacing;
    const float radius = kColorNoiseFactor * std::sqrt(noise * spacing);
    const bool averages = supports[i] > 0.0f && radius >= kLeastColorSpacings * spacing;
    radii[i] = averages ? radius : 0.0f;
    colors[i] = cloud.colors[order[i].index];
  }
  // More bits than the source has would only be noise to code.
  const float step = colors_fit_8_bits(cloud) ? 257.0f : 1.0f;
  colors = surface.weighted_means(radii, colors, executor, normals);
  for (std::size_t i = 0; i < order.size(); ++i)
    cloud.colors[order[i].index] = glm::u16vec3(step * glm::floor(colors[i] / step + 0.5f));
}

}  // namespace pointreel
