#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

namespace pointreel::e2e {

/// An 8-bit RGB picture; row 0 on top. Empty if the file cannot be read.
struct Picture {
  glm::ivec2 size{0};
  std::vector<glm::u8vec3> pixels;

  glm::u8vec3 at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) +
                  static_cast<std::size_t>(x)];
  }
  bool operator==(const Picture&) const = default;
};

Picture read_picture(const std::filesystem::path& png);

/// Those from `top` on, without `bottom`; both within the picture.
Picture rows(const Picture& picture, int top, int bottom);

/// Where a colour is in a picture: how many pixels have it, and their mean place.
struct Patch {
  std::size_t pixels = 0;
  glm::dvec2 center{0.0};
};

/// Pixels in which the channels marked 1 are bright and those marked 0 dark, whatever the light.
Patch find_hue(const Picture& picture, const glm::ivec3& bright);

}  // namespace pointreel::e2e
