#include "client/render/splatting.h"

#include <array>
#include <utility>

namespace pointreel {
namespace {

/// By what the visibility pass pushes a splat back, in its enlarged radii: neighbours on the same
/// surface then pass the depth test (ERRATA 9).
constexpr float kDepthTolerance = 1.0f;

/// By what the paper enlarges (Figure 3).
constexpr float kEnlargement = 2.0f;

}  // namespace

const char* name(Splatting splatting) {
  switch (splatting) {
    case Splatting::regular:
      return "regular";
    case Splatting::no_depth:
      return "no-depth";
    case Splatting::two_pass:
      return "two-pass";
    case Splatting::enlarged:
      return "enlarged";
    case Splatting::enlarged_shading:
      return "enlarged-shading";
    case Splatting::normalized:
      return "normalized";
  }
  return "";
}

SplatScales scales_of(Splatting splatting, const SplatScales& chosen) {
  switch (splatting) {
    case Splatting::enlarged:
      return {kEnlargement, kEnlargement};
    case Splatting::enlarged_shading:
      return {1.0f, kEnlargement};
    case Splatting::normalized:
      return chosen;
    default:
      return {};
  }
}

Result<Splatter> Splatter::create() {
  Splatter splatter;
  auto resolve =
      gl::make_program(std::array{gl::Stage{GL_VERTEX_SHADER, {"shaders/whole_picture.vert.glsl"}},
                                  gl::Stage{GL_FRAGMENT_SHADER, {"shaders/resolve.frag.glsl"}}});
  if (!resolve) return fail(resolve.error().message);
  splatter.resolve_ = std::move(*resolve);
  splatter.no_attributes_ = gl::VertexArray::create();
  return splatter;
}

Result<void> Splatter::resize(glm::ivec2 size, const gl::Texture& depth) {
  gl::Texture sums = gl::make_texture(GL_RGBA32F, size.x, size.y);
  Result<gl::Framebuffer> splats = gl::make_framebuffer(sums, depth);
  if (!splats) return fail(splats.error().message);
  sums_ = std::move(sums);
  splats_ = std::move(*splats);
  return {};
}

void Splatter::draw(InstancingMethod& method, const InstanceBuffer& instances, Splatting splatting,
                    const SplatScales& scales, const PixelRect& region, GLuint picture) const {
  if (splatting != Splatting::regular && splatting != Splatting::no_depth) {
    glBindFramebuffer(GL_FRAMEBUFFER, splats_.name());
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    method.draw(instances, Pass::surfel_depth, {scales.visibility, kDepthTolerance});
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_FALSE);
  }
  if (splatting == Splatting::no_depth) glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  if (splatting == Splatting::normalized) {
    draw_normalized(method, instances, scales.shading, region, picture);
  } else {
    draw_blended(method, instances, scales.shading, picture);
  }
  glDisable(GL_BLEND);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
}

void Splatter::draw_blended(InstancingMethod& method, const InstanceBuffer& instances, float scale,
                            GLuint picture) const {
  glBindFramebuffer(GL_FRAMEBUFFER, picture);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  method.draw(instances, Pass::surfel_blend, {scale, 0.0f});
}

void Splatter::draw_normalized(InstancingMethod& method, const InstanceBuffer& instances,
                               float scale, const PixelRect& region, GLuint picture) const {
  glBindFramebuffer(GL_FRAMEBUFFER, splats_.name());
  const std::array<GLfloat, 4> nothing{};
  glClearNamedFramebufferfv(splats_.name(), GL_COLOR, 0, nothing.data());
  glBlendFunc(GL_ONE, GL_ONE);
  method.draw(instances, Pass::surfel_sum, {scale, 0.0f});

  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  glBindFramebuffer(GL_FRAMEBUFFER, picture);
  glBindTextureUnit(0, sums_.name());
  glUseProgram(resolve_.name());
  glBindVertexArray(no_attributes_.name());
  glEnable(GL_SCISSOR_TEST);
  glScissor(region.min.x, region.min.y, region.max.x - region.min.x, region.max.y - region.min.y);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_SCISSOR_TEST);
}

}  // namespace pointreel
