#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "codec/octree/neighbor_prediction.h"

/// The colours that the transform works on: Y', Cb, Cr of ITU-R BT.709 from R'G'B' as they are
/// stored (sRGB), full range, in steps of 1/64 of an 8-bit value, in integers. FORMAT.md, "Colour
/// space".
namespace pointreel {

/// Steps of the transform's values in one of an 8-bit colour.
inline constexpr int kValuesPerStep = 64;

/// Y' is 0 to 16320, Cb and Cr -8160 to 8160; the fourth lane is 0.
inline Int4 ycbcr_from_rgb(const glm::u16vec3& color) {
  // 16 bits to 1/64 of 8 bits: exact where the colour is 257 times an 8-bit value.
  const auto scaled = [](int v) { return (v * 255 + 512) >> 10; };
  const Int4 sum = scaled(color.r) * Int4{13933, -7509, 32768, 0} +
                   scaled(color.g) * Int4{46871, -25259, -29763, 0} +
                   scaled(color.b) * Int4{4732, 32768, -3005, 0};
  return (sum + 32768) >> 16;
}

inline Short4 value_from_color(const glm::u16vec3& color) {
  return stored_value(ycbcr_from_rgb(color) + fourth_lane(0));
}

/// Rounded to 8 bits, times 257. Values that no colour has are clamped; |v| <= 2^14.
inline glm::u16vec3 rgb_from_ycbcr(const Int4& v) {
  const Int4 sum = (v[0] << 14) + v[1] * Int4{0, -3069, 30402, 0} + v[2] * Int4{25802, -7670, 0, 0};
  const Int4 rgb = clamp((sum + (1 << 19)) >> 20, 0, 255) * 257;
  return {static_cast<std::uint16_t>(rgb[0]), static_cast<std::uint16_t>(rgb[1]),
          static_cast<std::uint16_t>(rgb[2])};
}

inline glm::u16vec3 color_from_value(const Short4& value) { return rgb_from_ycbcr(load(value)); }

/// Of a frame whose colours have 16 bits: not rounded to 8, with the 14 that values have.
inline glm::u16vec3 color_16_from_value(const Short4& value) {
  const Int4 v = load(value);
  const Int4 sum = (v[0] << 14) + v[1] * Int4{0, -3069, 30402, 0} + v[2] * Int4{25802, -7670, 0, 0};
  const Int4 rgb = clamp(((sum >> 8) * 257 + (1 << 11)) >> 12, 0, 65535);
  return {static_cast<std::uint16_t>(rgb[0]), static_cast<std::uint16_t>(rgb[1]),
          static_cast<std::uint16_t>(rgb[2])};
}

}  // namespace pointreel
