#pragma once

#include <cstddef>
#include <vector>

#include <glm/glm.hpp>

namespace pointreel {

/// The light that comes from all directions, as an equirectangular picture in linear light. The
/// first row is around the zenith. Columns run to the right around somebody who stands in the
/// middle; the middle column is in front of him.
struct EnvironmentMap {
  int width = 0, height = 0;
  std::vector<glm::vec3> texels;  ///< finite, >= 0

  const glm::vec3& at(int x, int y) const {
    return texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
  glm::vec3& at(int x, int y) {
    return texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

/// The direction to the middle of a texel: y is up, -z is in front, x is to the right.
glm::vec3 direction_of_texel(const EnvironmentMap& map, int x, int y);

/// The solid angle of a texel of a row.
float solid_angle_of_texel(const EnvironmentMap& map, int y);

/// The light of a photographer's studio: soft walls, a large lamp in front to the left and above, a
/// larger and weaker one to the right, and one behind that lights outlines.
EnvironmentMap studio_environment();

}  // namespace pointreel
