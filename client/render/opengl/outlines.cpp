#include "client/render/opengl/outlines.h"

#include <utility>

#include "common/base/try.h"

namespace pointreel {

OutlineSmoother::OutlineSmoother()
    : program_({{GL_VERTEX_SHADER, {"shaders/whole_picture.vert.glsl"}},
                {GL_FRAGMENT_SHADER, {"shaders/outlines.frag.glsl"}}}) {}

Result<void> OutlineSmoother::resize(glm::ivec2 size, const gl::Texture& color) {
  gl::Framebuffer picture = TRY(gl::make_framebuffer(color));
  copy_ = gl::make_texture(GL_SRGB8_ALPHA8, size.x, size.y);
  picture_ = std::move(picture);
  color_ = color.name();
  return {};
}

Result<void> OutlineSmoother::draw(const PixelRect& region) {
  if (region.empty()) return {};
  TRY(program_.use());
  // A shader may not read what it writes.
  const glm::ivec2 extent = region.max - region.min;
  glCopyImageSubData(color_, GL_TEXTURE_2D, 0, region.min.x, region.min.y, 0, copy_.name(),
                     GL_TEXTURE_2D, 0, region.min.x, region.min.y, 0, extent.x, extent.y, 1);
  glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  glBindTextureUnit(0, copy_.name());
  glUniform4i(0, region.min.x, region.min.y, region.max.x - 1, region.max.y - 1);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
  glEnable(GL_SCISSOR_TEST);
  glScissor(region.min.x, region.min.y, extent.x, extent.y);
  glBindVertexArray(no_attributes_.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_SCISSOR_TEST);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  return {};
}

}  // namespace pointreel
