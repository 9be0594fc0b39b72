#include "client/render/opengl/eye_dome_lighting.h"

#include "common/base/try.h"

namespace pointreel {

EyeDomeLighting::EyeDomeLighting()
    : program_({{GL_VERTEX_SHADER, {"shaders/whole_picture.vert.glsl"}},
                {GL_FRAGMENT_SHADER, {"shaders/eye_dome.frag.glsl"}}}) {}

Result<void> EyeDomeLighting::resize(const gl::Texture& color, const gl::Texture& depth) {
  picture_ = TRY(gl::make_framebuffer(color));
  depth_ = depth.name();
  return {};
}

Result<void> EyeDomeLighting::draw(float strength, const gl::Texture* sums) {
  TRY(program_.use());
  glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  glBindTextureUnit(0, depth_);
  glBindTextureUnit(1, sums ? sums->name() : 0);
  glUniform1f(0, strength);
  glUniform1i(1, sums ? 1 : 0);
  glDisable(GL_DEPTH_TEST);
  // The shader's result multiplies the colours of the picture, in linear light.
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFuncSeparate(GL_ZERO, GL_SRC_COLOR, GL_ZERO, GL_ONE);
  glBindVertexArray(no_attributes_.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_BLEND);
  return {};
}

}  // namespace pointreel
