#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include <glm/glm.hpp>

#include "client/render/instance.h"
#include "client/render/view.h"

namespace pointreel {

/// The colour of an instance, in linear light.
inline glm::vec3 color_of_instance(const Instance& one) {
  const auto from_half = [](std::uint16_t half) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(half) << 13) * 0x1p112f;
  };
  return {from_half(one.color.x), from_half(one.color.y), from_half(one.color.z)};
}

/// Diffuse light from near the eye, and ambient light so that nothing is black (common.glsl).
inline float light_on(const glm::vec3& normal, const PictureView& view) {
  const float diffuse = std::max(glm::dot(normal, glm::vec3(view.light)), 0.0f);
  return view.light.w * (0.4f + 0.6f * diffuse) + (1.0f - view.light.w);
}

}  // namespace pointreel
