#include "client/render/splatting.h"

#include <algorithm>
#include <array>
#include <utility>

namespace pointreel {
namespace {

/// By what the visibility pass pushes a splat back, in its enlarged radii: neighbours on the same
/// surface then pass the depth test (ERRATA 9).
constexpr float kDepthTolerance = 1.0f;

/// By what the paper enlarges (Figure 3).
constexpr float kEnlargement = 2.0f;

void scissor(const PixelRect& part) {
  glScissor(part.min.x, part.min.y, part.max.x - part.min.x, part.max.y - part.min.y);
}

}  // namespace

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

Splatter::Splatter()
    : resolve_({{GL_VERTEX_SHADER, {"shaders/whole_picture.vert.glsl"}},
                {GL_FRAGMENT_SHADER, {"shaders/mean.glsl", "shaders/resolve.frag.glsl"}}}) {}

Result<void> Splatter::resize(glm::ivec2 size, const gl::Texture& color, const gl::Texture& depth) {
  gl::Texture sums = gl::make_texture(GL_RGBA32F, size.x, size.y);
  Result<gl::Framebuffer> splats = gl::make_framebuffer(sums, depth);
  if (!splats) return fail(splats.error().message);
  Result<gl::Framebuffer> picture = gl::make_framebuffer(color, depth);
  if (!picture) return fail(picture.error().message);
  Result<gl::Framebuffer> resolved = gl::make_framebuffer(color);
  if (!resolved) return fail(resolved.error().message);
  if (auto resized = reconstruction_.resize(size); !resized) return resized;
  sums_ = std::move(sums);
  summed_ = {glm::ivec2(0), size};  // whatever was there
  depth_ = depth.name();
  splats_ = std::move(*splats);
  picture_ = std::move(*picture);
  resolved_ = std::move(*resolved);
  return {};
}

Result<void> Splatter::draw(InstancingMethod& method, const InstanceBuffer& instances,
                            Splatting splatting, const SplatScales& scales, bool fill_holes,
                            const SplatPlace& place) {
  auto drawn = draw_passes(method, instances, splatting, scales,
                           fill_holes && splatting == Splatting::normalized, place);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_TRUE);
  return drawn;
}

Result<void> Splatter::draw_passes(InstancingMethod& method, const InstanceBuffer& instances,
                                   Splatting splatting, const SplatScales& scales, bool fill_holes,
                                   const SplatPlace& place) {
  if (splatting != Splatting::regular && splatting != Splatting::no_depth) {
    glBindFramebuffer(GL_FRAMEBUFFER, splats_.name());
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    auto drawn = method.draw(instances, Pass::surfel_depth, {scales.visibility, kDepthTolerance});
    if (drawn && fill_holes) drawn = reconstruction_.draw_backs(instances);
    if (!drawn) return drawn;
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_FALSE);
  }
  // The depth of what is drawn last is that of what is seen.
  if (splatting == Splatting::no_depth) glDepthFunc(GL_ALWAYS);
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  return splatting == Splatting::normalized
             ? draw_normalized(method, instances, scales.shading, fill_holes, place)
             : draw_blended(method, instances, scales.shading);
}

Result<void> Splatter::draw_blended(InstancingMethod& method, const InstanceBuffer& instances,
                                    float scale) const {
  glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  return method.draw(instances, Pass::surfel_blend, {scale, 0.0f});
}

Result<void> Splatter::draw_normalized(InstancingMethod& method, const InstanceBuffer& instances,
                                       float scale, bool fill_holes, const SplatPlace& place) {
  glBindFramebuffer(GL_FRAMEBUFFER, splats_.name());
  // All of it are 16 bytes a pixel, which takes a while.
  const std::array<GLfloat, 4> nothing{};
  scissor(around(std::exchange(summed_, place.region), place.region));
  glEnable(GL_SCISSOR_TEST);
  glClearNamedFramebufferfv(splats_.name(), GL_COLOR, 0, nothing.data());
  glDisable(GL_SCISSOR_TEST);
  glBlendFunc(GL_ONE, GL_ONE);
  if (auto drawn = method.draw(instances, Pass::surfel_sum, {scale, 0.0f}); !drawn) return drawn;

  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  Reconstruction::Filling filling{};
  if (fill_holes) {
    const auto filled = reconstruction_.fill(sums_, place.region, place.radius);
    if (!filled) return tl::unexpected(filled.error());
    filling = *filled;
  }
  if (auto used = resolve_.use(); !used) return used;
  glBindFramebuffer(GL_FRAMEBUFFER, resolved_.name());
  glBindTextureUnit(0, sums_.name());
  glBindTextureUnit(1, filling.colors);
  glBindTextureUnit(2, depth_);
  glBindTextureUnit(3, filling.crowd);
  glUniform1i(0, fill_holes ? 1 : 0);
  glUniform1f(1, static_cast<float>(std::max(filling.crowd_edge, 1)));
  glBindVertexArray(no_attributes_.name());
  glEnable(GL_SCISSOR_TEST);
  scissor(place.region);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  return {};
}

}  // namespace pointreel
