#include "client/render/reconstruction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "client/render/instancing/instance_array.h"

namespace pointreel {
namespace {

/// Of large clouds the backs of one surfel in a few suffice, down to about so many; which ones,
/// their places decide and not their order, so that the picture does not depend on that. Fewer
/// would have to be larger, and widen the outlines of dense clouds.
constexpr std::size_t kBacks = 16384;
constexpr std::size_t kFewest = 4;
/// Half the edge of a back in its radii, where none is left out. Less leaves holes between a
/// scanner's curves, more widens outlines.
constexpr float kReach = 1.2f;
/// How far backs are moved away from the eye, in their radii: those of a thin sheet stay behind its
/// front.
constexpr float kBackTolerance = 1.0f;
/// Gaps between surfels are about so many of their radii wide, at most.
constexpr float kGap = 6.5f;
/// Edge of the squares of the finest means, in pixels (pull_sums.frag.glsl).
constexpr int kFinest = 4;
/// No hole is filled that is farther from all colours than this share of the picture's height.
constexpr int kFarthest = 8;

gl::LateProgram picture_program(std::vector<std::string_view> fragment_files) {
  return gl::LateProgram({{GL_VERTEX_SHADER, {"shaders/whole_picture.vert.glsl"}},
                          {GL_FRAGMENT_SHADER, std::move(fragment_files)}});
}

/// The texels of a level `times` as coarse that a part touches, and one more on each side, which
/// sampling between texels touches.
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
  auto framebuffer = gl::make_framebuffer(level.texture);
  if (!framebuffer) return fail(framebuffer.error().message);
  level.framebuffer = std::move(*framebuffer);
  return level;
}

Result<void> Reconstruction::resize(glm::ivec2 size) {
  std::vector<Level> pulled, pushed;
  glm::ivec2 texels = (size + kFinest - 1) / kFinest;
  for (int edge = kFinest;; edge *= 2, texels = (texels + 1) / 2) {
    auto level = make_level(texels);
    if (!level) return fail(level.error().message);
    pulled.push_back(std::move(*level));
    if (edge * kFarthest >= size.y || texels == glm::ivec2(1)) break;
    auto filled = make_level(texels);
    if (!filled) return fail(filled.error().message);
    pushed.push_back(std::move(*filled));
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

Result<void> Reconstruction::draw_backs(const InstanceBuffer& instances) {
  if (auto used = back_.use(); !used) return used;
  const std::size_t one_in = std::clamp<std::size_t>(instances.size() / kBacks, 1, kFewest);
  bind_instance_array(points_, instances);
  glEnable(GL_PROGRAM_POINT_SIZE);
  glUniform1f(0, kReach * std::sqrt(static_cast<float>(one_in)));
  glUniform1f(1, kBackTolerance);
  glUniform1ui(2, static_cast<GLuint>(one_in));
  glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(instances.size()));
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
  // What the last picture left behind becomes 0 again.
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
    if (auto used = (finest ? pull_sums_ : pull_).use(); !used) return tl::unexpected(used.error());
    glBindTextureUnit(0, finer->name());
    to_pull = coarser_part(to_pull, finest ? kFinest : 2, level.size);
    draw(level, to_pull);
    finer = &level.texture;
  }
  if (auto used = push_.use(); !used) return tl::unexpected(used.error());
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
