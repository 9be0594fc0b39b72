#include "client/render/opengl/reconstruction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "client/render/hole_rules.h"
#include "client/render/opengl/instancing/instance_array.h"
#include "client/render/opengl/picture_program.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

using namespace hole_rules;

/// The texels of a level that is `times` as coarse that overlap `part`, and one more on each side,
/// which linear filtering reads.
PixelRect coarser_part(const PixelRect& part, int times, glm::ivec2 coarser_size) {
  return {glm::max(part.min / times - 1, glm::ivec2(0)),
          glm::min((part.max + times - 1) / times + 1, coarser_size)};
}

}  // namespace

Reconstruction::Reconstruction()
    : back_({{GL_VERTEX_SHADER,
              {"instancing/shaders/instance.glsl", "instancing/attribute/fetch.glsl",
               "shaders/back.vert.glsl"}},
             {GL_FRAGMENT_SHADER, {"shaders/nothing.frag.glsl"}}}),
      see_through_(picture_program({"shaders/see_through.frag.glsl"})),
      pull_sums_(picture_program({"shaders/mean.glsl", "shaders/pull_sums.frag.glsl"})),
      pull_(picture_program({"shaders/pull.frag.glsl"})),
      push_(picture_program({"shaders/push.frag.glsl"})),
      points_(make_instance_array(0)) {}

Result<Reconstruction::Level> Reconstruction::make_level(glm::ivec2 size) {
  Level level{gl::make_texture(GL_RGBA32F, size.x, size.y), {}, size};
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTextureParameteri(level.texture.name(), filter, GL_LINEAR);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTextureParameteri(level.texture.name(), wrap, GL_CLAMP_TO_EDGE);
  level.framebuffer = TRY(gl::make_framebuffer(level.texture));
  return level;
}

Result<void> Reconstruction::resize(glm::ivec2 size) {
  std::vector<Level> pulled, pushed;
  glm::ivec2 texels = (size + kFinest - 1) / kFinest;
  for (int edge = kFinest;; edge *= 2, texels = (texels + 1) / 2) {
    pulled.push_back(TRY(make_level(texels)));
    if (edge * kFarthest >= size.y || texels == glm::ivec2(1)) break;
    pushed.push_back(TRY(make_level(texels)));
  }
  for (const Level& level : pulled) {
    const std::array<GLfloat, 4> nothing{};
    glClearNamedFramebufferfv(level.framebuffer.name(), GL_COLOR, 0, nothing.data());
  }
  size_ = size;
  pulled_region_ = {};
  pulled_ = std::move(pulled);
  pushed_ = std::move(pushed);
  return {};
}

Result<void> Reconstruction::draw_backs(const InstanceBuffer& instances, std::uint32_t one_in) {
  TRY(back_.use());
  bind_instance_array(points_, instances);
  glEnable(GL_PROGRAM_POINT_SIZE);
  glUniform1f(0, kReach * std::sqrt(static_cast<float>(one_in)));
  glUniform1f(1, kBackTolerance);
  glUniform1ui(2, one_in);
  glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(instances.size()));
  return {};
}

Result<void> Reconstruction::clear_see_through(GLuint depth, float radius, float nearest) {
  TRY(see_through_.use());
  glBindVertexArray(no_attributes_.name());
  glBindTextureUnit(0, depth);
  glUniform1f(0, radius);
  glUniform1f(1, nearest);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  return {};
}

void Reconstruction::draw(const Level& level, const PixelRect& part) {
  glBindFramebuffer(GL_FRAMEBUFFER, level.framebuffer.name());
  glViewport(0, 0, level.size.x, level.size.y);
  const glm::ivec2 size = part.max - part.min;
  glScissor(part.min.x, part.min.y, size.x, size.y);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

Result<Reconstruction::Filling> Reconstruction::fill(const gl::Texture& sums,
                                                     const PixelRect& region, float radius) {
  // Where only the last picture had colours, the levels become 0 again.
  PixelRect to_pull = around(pulled_region_, region);
  pulled_region_ = region;
  std::vector<PixelRect> to_push;
  PixelRect part = region;
  for (const Level& level : pushed_) {
    part = coarser_part(part, to_push.empty() ? kFinest : 2, level.size);
    to_push.push_back(part);
  }

  glBindVertexArray(no_attributes_.name());
  glEnable(GL_SCISSOR_TEST);
  const gl::Texture* finer = &sums;
  for (const Level& level : pulled_) {
    const bool finest = finer == &sums;
    TRY((finest ? pull_sums_ : pull_).use());
    glBindTextureUnit(0, finer->name());
    to_pull = coarser_part(to_pull, finest ? kFinest : 2, level.size);
    draw(level, to_pull);
    finer = &level.texture;
  }
  TRY(push_.use());
  const gl::Texture* filled = finer;
  for (std::size_t i = pushed_.size(); i-- > 0;) {
    glBindTextureUnit(0, pulled_[i].texture.name());
    glBindTextureUnit(1, filled->name());
    draw(pushed_[i], to_push[i]);
    filled = &pushed_[i].texture;
  }
  glDisable(GL_SCISSOR_TEST);
  glViewport(0, 0, size_.x, size_.y);
  std::size_t crowd = 0;
  int edge = kFinest;
  while (crowd + 1 < pulled_.size() && static_cast<float>(2 * edge) <= kGap * radius) {
    ++crowd;
    edge *= 2;
  }
  return Filling{filled->name(), pulled_[crowd].texture.name(), edge};
}

}  // namespace pointreel
