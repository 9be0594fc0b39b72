#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "pointreel/error.h"

namespace pointreel {

/// A picture in 8-bit sRGB. Rows run from top to bottom, pixels from left to right.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<glm::u8vec3> pixels;

  const glm::u8vec3& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

/// Writes a PNG file, and replaces a file of that name. Fails with ErrorCode::io.
Result<void> write_png(const std::string& path, const Image& image);

}  // namespace pointreel
