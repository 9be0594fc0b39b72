#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "codec/octree/attribute_value.h"

/// The colour space of the transform: Y', Cb and Cr of ITU-R BT.709, computed from R'G'B' as they
/// are stored (sRGB), full range, as integers in units of 1/64 of an 8-bit value. FORMAT.md,
/// "Colour space".
namespace pointreel {

/// The number of the transform's steps in one step of an 8-bit colour.
inline constexpr int kValuesPerStep = 64;

/// Y' is 0 to 16320, and Cb and Cr are -8160 to 8160. The fourth lane is 0.
inline Int4 ycbcr_from_rgb(const glm::u16vec3& color) {
  // From 16 bits to 1/64 of 8 bits. Exact if the colour is 257 times an 8-bit value.
  const auto scaled = [](int v) { return (v * 255 + 512) >> 10; };
  const Int4 sum = scaled(color.r) * Int4{13933, -7509, 32768, 0} +
                   scaled(color.g) * Int4{46871, -25259, -29763, 0} +
                   scaled(color.b) * Int4{4732, 32768, -3005, 0};
  return (sum + 32768) >> 16;
}

inline Short4 value_from_color(const glm::u16vec3& color) {
  return stored_value(ycbcr_from_rgb(color) + fourth_lane(0));
}

/// The colour rounded to 8 bits, times 257. Values outside the range of colours are clamped;
/// |v| <= 2^14.
inline glm::u16vec3 rgb_from_ycbcr(const Int4& v) {
  const Int4 sum = (v[0] << 14) + v[1] * Int4{0, -3069, 30402, 0} + v[2] * Int4{25802, -7670, 0, 0};
  const Int4 rgb = clamp((sum + (1 << 19)) >> 20, 0, 255) * 257;
  return {static_cast<std::uint16_t>(rgb[0]), static_cast<std::uint16_t>(rgb[1]),
          static_cast<std::uint16_t>(rgb[2])};
}

inline glm::u16vec3 color_from_value(const Short4& value) { return rgb_from_ycbcr(load(value)); }

/// The same for frames with 16-bit colours: not rounded to 8 bits, but with all 14 that values
/// have.
inline glm::u16vec3 color_16_from_value(const Short4& value) {
  const Int4 v = load(value);
  const Int4 sum = (v[0] << 14) + v[1] * Int4{0, -3069, 30402, 0} + v[2] * Int4{25802, -7670, 0, 0};
  const Int4 rgb = clamp(((sum >> 8) * 257 + (1 << 11)) >> 12, 0, 65535);
  return {static_cast<std::uint16_t>(rgb[0]), static_cast<std::uint16_t>(rgb[1]),
          static_cast<std::uint16_t>(rgb[2])};
}

/// The colour space of exact layers: YCoCg-R (H. Malvar and G. Sullivan, "YCoCg-R: A color space
/// with RGB reversibility and low dynamic range", JVT-I014r3, 2003) of 8-bit colours, as Y, Cg, Co.
/// Y is 0 to 255, and the others are -255 to 255.
inline Short4 exact_value_from_color(const glm::u16vec3& color) {
  const auto scaled = [](int v) { return (v + 128) / 257; };
  const int r = scaled(color.r), g = scaled(color.g), b = scaled(color.b);
  const int co = r - b, t = b + (co >> 1), cg = g - t;
  return stored_value(Int4{t + (cg >> 1), cg, co, 0} + fourth_lane(0));
}

/// The inverse. Values that no colour has are clamped.
inline glm::u16vec3 color_from_exact_value(const Short4& value) {
  const int cg = value.lanes[1], co = value.lanes[2], t = value.lanes[0] - (cg >> 1);
  const int b = t - (co >> 1);
  const Int4 rgb = clamp(Int4{b + co, cg + t, b, 0}, 0, 255) * 257;
  return {static_cast<std::uint16_t>(rgb[0]), static_cast<std::uint16_t>(rgb[1]),
          static_cast<std::uint16_t>(rgb[2])};
}

}  // namespace pointreel
