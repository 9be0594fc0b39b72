#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "client/render/software/tile.h"

namespace pointreel {

/// Alpha of pixels that show an element and not the background.
inline constexpr std::uint8_t kDrawn = 255;

/// A picture with depths. Rows run from the lowest to the highest, as in OpenGL.
struct Picture {
  TileGrid grid;
  std::vector<glm::u8vec4> colors;  ///< sRGB; alpha is kDrawn where an element was drawn
  std::vector<float> depths;        ///< reversed: near plane / depth; 0 where nothing is
  std::vector<glm::vec3> normals;   ///< means of unit vectors; only if pixels are shaded late
                                    ///< (shading.h), and undefined where nothing is drawn
  std::vector<std::uint8_t> busy;   ///< for each tile, whether it has any depth but 0

  explicit Picture(glm::ivec2 size = {0, 0})
      : grid(size),
        colors(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y)),
        depths(colors.size()),
        busy(static_cast<std::size_t>(grid.count())) {}

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.size.x) +
           static_cast<std::size_t>(x);
  }
  bool is_drawn(int x, int y) const { return colors[index(x, y)].a == kDrawn; }
};

/// Conversions between linear light and bytes in sRGB, by tables.
class SrgbTables {
 public:
  static const SrgbTables& get();

  /// The byte for 0 to 1; less and more are clamped. Wrong by at most 0.1 steps before rounding.
  std::uint8_t encode(float linear) const {
    const float scaled = linear * static_cast<float>(kSteps) + 0.5f;
    // The comparison is written so that a NaN becomes 0.
    const int at = scaled > 0.0f ? static_cast<int>(scaled < kSteps ? scaled : kSteps) : 0;
    return bytes_[static_cast<std::size_t>(at)];
  }
  glm::u8vec4 encode(const glm::vec3& linear, std::uint8_t alpha) const {
    return {encode(linear.r), encode(linear.g), encode(linear.b), alpha};
  }
  float decode(std::uint8_t byte) const { return linear_[byte]; }
  glm::vec3 decode(const glm::u8vec4& color) const {
    return {decode(color.r), decode(color.g), decode(color.b)};
  }

 private:
  SrgbTables();

  static constexpr int kSteps = 16384;
  std::array<std::uint8_t, kSteps + 1> bytes_;
  std::array<float, 256> linear_;
};

}  // namespace pointreel
