#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <epoxy/gl.h>

#include "client/render/opengl/gl_renderer.h"

namespace pointreel {

/// How much of each pixel of the last picture is covered: 0 if nothing was drawn there, 255 if the
/// background does not show. Rows run from top to bottom. Empty before the first picture.
inline std::vector<std::uint8_t> read_alpha(Renderer& renderer) {
  if (renderer.texture() == 0) return {};
  GLint width = 0, height = 0;
  glGetTextureLevelParameteriv(renderer.texture(), 0, GL_TEXTURE_WIDTH, &width);
  glGetTextureLevelParameteriv(renderer.texture(), 0, GL_TEXTURE_HEIGHT, &height);
  std::vector<std::uint8_t> pixels(4 * static_cast<std::size_t>(width * height)), alpha;
  glGetTextureImage(renderer.texture(), 0, GL_RGBA, GL_UNSIGNED_BYTE,
                    static_cast<GLsizei>(pixels.size()), pixels.data());
  for (int y = height - 1; y >= 0; --y)
    for (int x = 0; x < width; ++x)
      alpha.push_back(pixels[4 * static_cast<std::size_t>(y * width + x) + 3]);
  return alpha;
}

}  // namespace pointreel
