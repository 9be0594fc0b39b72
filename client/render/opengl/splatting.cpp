#include "client/render/opengl/splatting.h"

#include <algorithm>
#include <array>
#include <utility>

#include "client/render/hole_rules.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

using hole_rules::kDepthTolerance;

void scissor(const PixelRect& part) {
  glScissor(part.min.x, part.min.y, part.max.x - part.min.x, part.max.y - part.min.y);
}

}  // namespace

Splatter::Splatter()
    : resolve_({{GL_VERTEX_SHADER, {"shaders/whole_picture.vert.glsl"}},
                {GL_FRAGMENT_SHADER, {"shaders/mean.glsl", "shaders/resolve.frag.glsl"}}}) {}

Result<void> Splatter::resize(glm::ivec2 size, const gl::Texture& color, const gl::Texture& depth) {
  gl::Texture sums = gl::make_texture(GL_RGBA32F, size.x, size.y);
  gl::Framebuffer splats = TRY(gl::make_framebuffer(sums, depth));
  gl::Framebuffer only_sums = TRY(gl::make_framebuffer(sums));
  gl::Framebuffer picture = TRY(gl::make_framebuffer(color, depth));
  gl::Framebuffer resolved = TRY(gl::make_framebuffer(color));
  TRY(reconstruction_.resize(size));
  sums_ = std::move(sums);
  summed_ = {glm::ivec2(0), size};  // the new texture has undefined contents
  depth_ = depth.name();
  splats_ = std::move(splats);
  only_sums_ = std::move(only_sums);
  picture_ = std::move(picture);
  resolved_ = std::move(resolved);
  return {};
}

Result<void> Splatter::draw(InstancingMethod& method, const InstanceBuffer& instances,
                            Splatting splatting, const SplatScales& scales, bool fill_holes,
                            const SplatPlace& place, const SplatLight* late) {
  auto drawn = draw_passes(method, instances, splatting, scales,
                           fill_holes && splatting == Splatting::normalized, place, late);
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
                                   const SplatPlace& place, const SplatLight* late) {
  if (splatting != Splatting::regular && splatting != Splatting::no_depth) {
    glBindFramebuffer(GL_FRAMEBUFFER, splats_.name());
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    TRY(method.draw(instances, Pass::surfel_depth, {scales.visibility, kDepthTolerance}));
    if (fill_holes && !place.signs_unknown)
      TRY(reconstruction_.draw_backs(instances, place.one_back_in));
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_FALSE);
  }
  // Whatever is drawn last is visible, and leaves its depth.
  if (splatting == Splatting::no_depth) glDepthFunc(GL_ALWAYS);
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  return splatting == Splatting::normalized
             ? draw_normalized(method, instances, scales.shading, fill_holes, place, late)
             : draw_blended(method, instances, scales.shading);
}

Result<void> Splatter::draw_blended(InstancingMethod& method, const InstanceBuffer& instances,
                                    float scale) const {
  glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  return method.draw(instances, Pass::surfel_blend, {scale, 0.0f});
}

void Splatter::clear_sums(const PixelRect& region) {
  // At 16 bytes per pixel, clearing the whole texture would take a while.
  const std::array<GLfloat, 4> nothing{};
  scissor(around(std::exchange(summed_, region), region));
  glEnable(GL_SCISSOR_TEST);
  glClearNamedFramebufferfv(splats_.name(), GL_COLOR, 0, nothing.data());
  glDisable(GL_SCISSOR_TEST);
}

Result<void> Splatter::draw_normalized(InstancingMethod& method, const InstanceBuffer& instances,
                                       float scale, bool fill_holes, const SplatPlace& place,
                                       const SplatLight* late) {
  glBindFramebuffer(GL_FRAMEBUFFER, splats_.name());
  clear_sums(place.region);
  glBlendFunc(GL_ONE, GL_ONE);
  TRY(method.draw(instances, Pass::surfel_sum, {scale, 0.0f}));
  if (late != nullptr) {
    late->show_normals();
    glBindFramebuffer(GL_FRAMEBUFFER, late->light.normals().name());
    TRY(method.draw(instances, Pass::surfel_sum, {scale, 0.0f}));
  }

  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  return finish(fill_holes, place, late);
}

Result<void> Splatter::finish(bool fill_holes, const SplatPlace& place, const SplatLight* late) {
  if (fill_holes && place.signs_unknown) {
    glBindFramebuffer(GL_FRAMEBUFFER, only_sums_.name());
    glEnable(GL_SCISSOR_TEST);
    scissor(place.region);
    TRY(reconstruction_.clear_see_through(depth_, place.radius, place.nearest));
    glDisable(GL_SCISSOR_TEST);
  }
  const gl::Texture* sums = &sums_;
  if (late != nullptr) sums = TRY(late->light.light(sums_));
  if (!fill_holes) return resolve(*sums, nullptr, place.region);
  const Reconstruction::Filling filling =
      TRY(reconstruction_.fill(*sums, place.region, place.pixels));
  return resolve(*sums, &filling, place.region);
}

Result<void> Splatter::draw_strips(StripPasses& strips, const InstanceBuffer& vertices,
                                   const std::function<Result<void>()>& points, bool fill_holes,
                                   const SplatPlace& place, const SplatLight* late) {
  const bool sums = fill_holes || late != nullptr;
  const auto draw_fronts = [&]() -> Result<void> {
    TRY(strips.draw_fronts(vertices));
    return points();
  };
  const auto draw = [&]() -> Result<void> {
    glBindFramebuffer(GL_FRAMEBUFFER, sums ? splats_.name() : picture_.name());
    if (sums) clear_sums(place.region);
    if (fill_holes && !place.signs_unknown) {
      glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
      TRY(strips.draw_backs(vertices));
      glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    }
    TRY(draw_fronts());
    if (late != nullptr) {
      late->show_normals();
      glBindFramebuffer(GL_FRAMEBUFFER, late->light.normals().name());
      glDepthFunc(GL_GEQUAL);
      TRY(draw_fronts());
    }
    glDisable(GL_DEPTH_TEST);
    return sums ? finish(fill_holes, place, late) : Result<void>();
  };
  auto drawn = draw();
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDisable(GL_CULL_FACE);
  glDisable(GL_SCISSOR_TEST);
  glDepthFunc(GL_GREATER);
  glEnable(GL_DEPTH_TEST);
  return drawn;
}

Result<void> Splatter::draw_lit(const std::function<Result<void>()>& draw_elements,
                                const SplatLight& late, const PixelRect& region) {
  glBindFramebuffer(GL_FRAMEBUFFER, splats_.name());
  clear_sums(region);
  TRY(draw_elements());
  late.show_normals();
  glBindFramebuffer(GL_FRAMEBUFFER, late.light.normals().name());
  glDepthFunc(GL_GEQUAL);
  TRY(draw_elements());
  glDepthFunc(GL_GREATER);
  glDisable(GL_DEPTH_TEST);
  const gl::Texture* lit = TRY(late.light.light(sums_));
  auto drawn = resolve(*lit, nullptr, region);
  glDisable(GL_SCISSOR_TEST);
  glEnable(GL_DEPTH_TEST);
  return drawn;
}

Result<void> Splatter::resolve(const gl::Texture& sums, const Reconstruction::Filling* filling,
                               const PixelRect& region) {
  TRY(resolve_.use());
  glBindFramebuffer(GL_FRAMEBUFFER, resolved_.name());
  glBindTextureUnit(0, sums.name());
  glBindTextureUnit(1, filling ? filling->colors : 0);
  glBindTextureUnit(2, depth_);
  glBindTextureUnit(3, filling ? filling->crowd : 0);
  glUniform1i(0, filling ? 1 : 0);
  glUniform1f(1, static_cast<float>(filling ? std::max(filling->crowd_edge, 1) : 1));
  glBindVertexArray(no_attributes_.name());
  glEnable(GL_SCISSOR_TEST);
  scissor(region);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  return {};
}

}  // namespace pointreel
