#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

namespace pointreel::e2e {

/// An 8-bit RGB picture with row 0 at the top. It is empty if the file cannot be read.
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

/// The rows from `top` up to, but not including, `bottom`. Both must be within the picture.
Picture rows(const Picture& picture, int top, int bottom);

/// A colour's place in a picture: the number of its pixels and their mean position.
struct Patch {
  std::size_t pixels = 0;
  glm::dvec2 center{0.0};
};

/// Finds the pixels whose channels are bright where `bright` is 1 and dark where it is 0, whatever
/// the light.
Patch find_hue(const Picture& picture, const glm::ivec3& bright);

}  // namespace pointreel::e2e
