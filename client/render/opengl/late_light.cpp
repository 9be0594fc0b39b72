#include "client/render/opengl/late_light.h"

#include <array>
#include <utility>

#include "client/render/opengl/instancing/instance_array.h"
#include "client/render/opengl/picture_program.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

gl::Texture make_filtered(GLenum format, int edge) {
  gl::Texture texture = gl::make_texture(format, edge, edge);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTextureParameteri(texture.name(), filter, GL_LINEAR);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTextureParameteri(texture.name(), wrap, GL_CLAMP_TO_EDGE);
  return texture;
}

constexpr int kGlossy = LightProbe::kGlossyEdge + 2;

}  // namespace

LateLight::LateLight()
    : shadow_program_({{GL_VERTEX_SHADER,
                        {"instancing/shaders/instance.glsl", "instancing/attribute/fetch.glsl",
                         "shaders/shading.glsl", "shaders/shadow.vert.glsl"}},
                       {GL_FRAGMENT_SHADER, {"shaders/nothing.frag.glsl"}}}),
      blur_(picture_program({"shaders/shadow_blur.frag.glsl"})),
      floor_(picture_program({"shaders/shading.glsl", "shaders/floor_shadow.frag.glsl"})),
      open_program_(picture_program({"shaders/shading.glsl", "shaders/open.frag.glsl"})),
      light_(picture_program({"shaders/shading.glsl", "shaders/light.frag.glsl"})),
      instances_(make_instance_array(0)) {
  glNamedBufferStorage(block_.name(), sizeof(ShadingView), nullptr, GL_DYNAMIC_STORAGE_BIT);
}

Result<void> LateLight::resize(glm::ivec2 size, const gl::Texture& depth) {
  if (size == size_ && depth.name() == depth_) return {};
  if (nearest_.name() == 0) {
    nearest_ = gl::make_texture(GL_DEPTH_COMPONENT32F, kShadowEdge, kShadowEdge);
    rows_ = gl::make_texture(GL_RG32F, kShadowEdge, kShadowEdge);
    moments_ = make_filtered(GL_RG32F, kShadowEdge);
    to_rows_ = TRY(gl::make_framebuffer(rows_));
    to_nearest_ = TRY(gl::make_framebuffer(rows_, nearest_));
    to_moments_ = TRY(gl::make_framebuffer(moments_));
    glossy_ = make_filtered(GL_RGB32F, kGlossy);
  }
  const glm::ivec2 squares = (size + 1) / 2;
  normals_ = gl::make_texture(GL_RGBA32F, size.x, size.y);
  open_ = gl::make_texture(GL_RGBA32F, squares.x, squares.y);
  lit_ = gl::make_texture(GL_RGBA32F, size.x, size.y);
  normals_and_depth_ = TRY(gl::make_framebuffer(normals_, depth));
  to_open_ = TRY(gl::make_framebuffer(open_));
  to_lit_ = TRY(gl::make_framebuffer(lit_));
  size_ = size;
  depth_ = depth.name();
  return {};
}

Result<void> LateLight::begin(glm::ivec2 size, const gl::Texture& depth, const ShadingView& shading,
                              const LightProbe& probe, const InstanceBuffer& instances) {
  TRY(resize(size, depth));
  glNamedBufferSubData(block_.name(), 0, sizeof(shading), &shading);
  glBindBufferBase(GL_UNIFORM_BUFFER, 1, block_.name());
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(glossy_.name(), 0, 0, 0, kGlossy, kGlossy, GL_RGB, GL_FLOAT,
                      probe.glossy.data());
  const std::array<GLfloat, 4> nothing{};
  glClearNamedFramebufferfv(normals_and_depth_.name(), GL_COLOR, 0, nothing.data());
  if (shading.reach.w != kLateLight) return {};
  return draw_shadow(instances);
}

Result<void> LateLight::draw_shadow(const InstanceBuffer& instances) {
  TRY(shadow_program_.use());
  glBindFramebuffer(GL_FRAMEBUFFER, to_nearest_.name());
  glViewport(0, 0, kShadowEdge, kShadowEdge);
  const GLfloat far = 0.0f;
  glClearNamedFramebufferfv(to_nearest_.name(), GL_DEPTH, 0, &far);
  bind_instance_array(instances_, instances);
  glEnable(GL_PROGRAM_POINT_SIZE);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(instances.size()));
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDisable(GL_DEPTH_TEST);
  TRY(blur_.use());
  glBindVertexArray(no_attributes_.name());
  const auto blur = [](const gl::Texture& from, const gl::Framebuffer& to, bool first) {
    glBindFramebuffer(GL_FRAMEBUFFER, to.name());
    glBindTextureUnit(0, from.name());
    glUniform2i(0, first ? 1 : 0, first ? 0 : 1);
    glUniform1i(1, first ? 1 : 0);
    glDrawArrays(GL_TRIANGLES, 0, 3);
  };
  blur(nearest_, to_rows_, true);
  blur(rows_, to_moments_, false);
  glViewport(0, 0, size_.x, size_.y);
  glEnable(GL_DEPTH_TEST);
  return {};
}

Result<void> LateLight::shade_floor() {
  TRY(floor_.use());
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFuncSeparate(GL_ZERO, GL_SRC_COLOR, GL_ZERO, GL_ONE);
  glBindTextureUnit(0, moments_.name());
  glBindVertexArray(no_attributes_.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_BLEND);
  return {};
}

Result<const gl::Texture*> LateLight::light(const gl::Texture& sums) {
  glBindVertexArray(no_attributes_.name());
  glBindTextureUnit(0, sums.name());
  glBindTextureUnit(1, normals_.name());
  glBindTextureUnit(2, depth_);
  TRY(open_program_.use());
  std::array<glm::vec2, 4 * kTaps> taps;
  for (int i = 0; i < 4 * kTaps; ++i) taps[static_cast<std::size_t>(i)] = tap(i % kTaps, i / kTaps);
  glUniform2fv(0, 4 * kTaps, &taps[0].x);
  glBindFramebuffer(GL_FRAMEBUFFER, to_open_.name());
  glViewport(0, 0, (size_.x + 1) / 2, (size_.y + 1) / 2);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  TRY(light_.use());
  glBindTextureUnit(3, open_.name());
  glBindTextureUnit(4, moments_.name());
  glBindTextureUnit(5, glossy_.name());
  glBindFramebuffer(GL_FRAMEBUFFER, to_lit_.name());
  glViewport(0, 0, size_.x, size_.y);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  return &lit_;
}

}  // namespace pointreel
