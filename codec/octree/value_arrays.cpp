#include "codec/octree/value_arrays.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "codec/octree/color_space.h"
#include "codec/octree/normal_space.h"

namespace pointreel {
namespace {

typedef float Float4 __attribute__((vector_size(16)));

/// The components of four values.
struct Components {
  Int4 first, second, third;
};

Components load_four(const Short4* values) {
  Int4 low, high;
  std::memcpy(&low, values, sizeof(low));
  std::memcpy(&high, values + 2, sizeof(high));
  const Int4 pairs = __builtin_shufflevector(low, high, 0, 2, 4, 6);
  const Int4 others = __builtin_shufflevector(low, high, 1, 3, 5, 7);
  return {(pairs << 16) >> 16, pairs >> 16, (others << 16) >> 16};
}

/// rgb_from_ycbcr.
void convert_four(const Components& v, glm::u16vec3* colors) {
  const auto rounded = [](const Int4& sum) { return clamp((sum + (1 << 19)) >> 20, 0, 255); };
  const Int4 luma = v.first << 14;
  const Int4 red = rounded(luma + v.third * 25802);
  const Int4 green = rounded(luma - v.second * 3069 - v.third * 7670);
  const Int4 blue = rounded(luma + v.second * 30402);
  // 257 times each of them.
  const auto doubled = [](const Int4& bytes) { return bytes | bytes << 8; };
  const Int4 two = doubled(red | green << 16), one = doubled(blue);
  const Int4 low = __builtin_shufflevector(two, one, 0, 4, 1, 5);
  const Int4 high = __builtin_shufflevector(two, one, 2, 6, 3, 7);
  // Eight bytes are written for each colour, of which the next colour replaces two.
  std::uint64_t eight[4];
  std::memcpy(eight, &low, sizeof(low));
  std::memcpy(eight + 2, &high, sizeof(high));
  auto* const bytes = reinterpret_cast<std::uint8_t*>(colors);
  for (std::size_t i = 0; i < 4; ++i) std::memcpy(bytes + 6 * i, &eight[i], 8);
}

void convert_four(const Components& v, glm::vec3* normals) {
  const Float4 x = __builtin_convertvector(v.first, Float4);
  const Float4 y = __builtin_convertvector(v.second, Float4);
  const Float4 z = __builtin_convertvector(v.third, Float4);
  const Float4 squared = x * x + y * y + z * z;
  const Float4 length = {std::sqrt(squared[0]), std::sqrt(squared[1]), std::sqrt(squared[2]),
                         std::sqrt(squared[3])};
  constexpr float kLeast = kUnitNormal / 4;
  const Int4 known = squared >= kLeast * kLeast;
  const auto divided = [&](const Float4& component) {
    return reinterpret_cast<Float4>(reinterpret_cast<Int4>(component / length) & known);
  };
  const Float4 a = divided(x), b = divided(y), c = divided(z);
  const Float4 low = __builtin_shufflevector(a, b, 0, 4, 1, 5);
  const Float4 high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Float4 four[4] = {
      __builtin_shufflevector(low, c, 0, 1, 4, 4), __builtin_shufflevector(low, c, 2, 3, 5, 5),
      __builtin_shufflevector(high, c, 0, 1, 6, 6), __builtin_shufflevector(high, c, 2, 3, 7, 7)};
  // Sixteen bytes are written for each normal, of which the next normal replaces four.
  auto* const bytes = reinterpret_cast<std::uint8_t*>(normals);
  for (std::size_t i = 0; i < 4; ++i) std::memcpy(bytes + 12 * i, &four[i], 16);
}

/// At least one is left for `convert_one`, since a little more is written than four attributes.
template <class Attribute, class Convert>
void convert(std::span<const Short4> values, Attribute* attributes, Convert convert_one) {
  std::size_t i = 0;
  for (; i + 4 < values.size(); i += 4) convert_four(load_four(&values[i]), attributes + i);
  for (; i < values.size(); ++i) attributes[i] = convert_one(values[i]);
}

}  // namespace

void colors_from_values(std::span<const Short4> values, glm::u16vec3* colors) {
  convert(values, colors, color_from_value);
}

void normals_from_values(std::span<const Short4> values, glm::vec3* normals) {
  convert(values, normals, normal_from_value);
}

}  // namespace pointreel
