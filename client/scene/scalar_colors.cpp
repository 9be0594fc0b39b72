#include "client/scene/scalar_colors.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "codec/core/build.h"

namespace pointreel {
namespace {

/// The colours of 0, 0.1 ... 1: lightness from 0.27 to 0.93 and hue from 305 to 105 degrees in
/// Oklab (B. Ottosson, "A perceptual color space for image processing", 2020), with a chroma of
/// 0.15, or as much as sRGB has.
constexpr std::array<std::uint32_t, 11> kRamp = {0x37005b, 0x34207f, 0x1f3f98, 0x005f97,
                                                 0x007899, 0x00919d, 0x00ab9d, 0x18c590,
                                                 0x7ad67f, 0xbce370, 0xf7ed6c};

/// Twelve hues in an order in which neighbours are far apart, bright ones first.
constexpr std::array<std::uint32_t, 12> kLabels = {0x4e9af1, 0xf28e2b, 0x59b35c, 0xd94f70,
                                                   0xf2d147, 0x8a63d2, 0x46c8c1, 0xa8643c,
                                                   0xf0a6c8, 0x6f7d1f, 0xb9d76a, 0x3c5a99};

glm::u8vec3 color_of(std::uint32_t rgb) { return {rgb >> 16, rgb >> 8 & 0xff, rgb & 0xff}; }

glm::u16vec3 wide(const glm::u8vec3& color) { return glm::u16vec3(color) * std::uint16_t{257}; }

/// The colour that most of a node's children have; of those that are equally frequent, the first.
glm::u16vec3 most_frequent(std::span<const glm::u16vec3> children) {
  glm::u16vec3 best = children.front();
  std::ptrdiff_t most = 0;
  for (const glm::u16vec3& color : children) {
    const auto count = std::ranges::count(children, color);
    if (count > most) {
      most = count;
      best = color;
    }
  }
  return best;
}

}  // namespace

glm::u8vec3 ramp_color(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * (kRamp.size() - 1);
  const auto first = std::min(static_cast<std::size_t>(at), kRamp.size() - 2);
  const glm::dvec3 from(color_of(kRamp[first])), to(color_of(kRamp[first + 1]));
  return glm::u8vec3(glm::mix(from, to, at - static_cast<double>(first)) + 0.5);
}

glm::u8vec3 label_color(int label) {
  const int count = static_cast<int>(kLabels.size());
  return color_of(kLabels[static_cast<std::size_t>((label % count + count) % count)]);
}

std::vector<glm::u16vec3> scalar_colors(const ShownScalar& shown, std::span<const float> values) {
  std::vector<glm::u16vec3> colors(values.size());
  const auto& [name, least, most, labels] = shown.range;
  const double range = most - least;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double value = values[i];
    if (std::isnan(value)) {
      colors[i] = wide(kUnknownColor);
    } else if (labels) {
      colors[i] = wide(label_color(static_cast<int>(std::clamp(value, -1e9, 1e9))));
    } else {
      colors[i] = wide(ramp_color(range > 0.0 ? (value - least) / range : 0.5));
    }
  }
  return colors;
}

std::vector<glm::u16vec3> scalar_node_colors(const ShownScalar& shown, const Svo& svo,
                                             std::span<const float> values) {
  PointCloud leaves;
  leaves.colors = scalar_colors(shown, values);
  if (!shown.range.labels) {
    leaves.positions.resize(leaves.colors.size());
    return mean_attributes(svo, leaves).colors;
  }
  std::vector<glm::u16vec3> colors(svo.internal_count());
  colors.insert(colors.end(), leaves.colors.begin(), leaves.colors.end());
  for (std::uint32_t node = svo.internal_count(); node-- > 0;) {
    const auto count = static_cast<std::size_t>(std::popcount(svo.masks[node]));
    colors[node] = most_frequent({colors.data() + svo.first_child[node], count});
  }
  return colors;
}

}  // namespace pointreel
