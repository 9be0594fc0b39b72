#include <algorithm>
#include <utility>

#include "client/render/opengl/instancing/methods.h"
#include "client/render/opengl/instancing/pass_programs.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::size_t kTexelsPerInstance = 2;

/// Slomp et al., Geometry Instancing, section IV-B, "textures and texture buffers". Uses texture
/// buffers, which have no limits on width and height.
class TextureInstancing final : public InstancingMethod {
 public:
  explicit TextureInstancing(const PassPrograms::Stages& stages) : programs_(stages) {
    GLint texels = 0;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    // Texture buffers may begin at multiples of 64 KiB on every driver.
    constexpr std::size_t kGranule = 65536 / sizeof(Instance);
    largest_ = static_cast<std::size_t>(texels) / kTexelsPerInstance / kGranule * kGranule;
  }

  Result<void> draw(const InstanceBuffer& instances, Pass pass,
                    const PassParameters& parameters) override {
    TRY(programs_.use(pass, parameters));
    glBindVertexArray(no_attributes_.name());
    glBindTextureUnit(0, texture_.name());
    const PassTemplate shape = pass_template(pass);
    for (std::size_t first = 0; first < instances.size(); first += largest_) {
      const std::size_t count = std::min(largest_, instances.size() - first);
      glTextureBufferRange(texture_.name(), GL_RGBA32UI, instances.name(),
                           static_cast<GLintptr>(first * sizeof(Instance)),
                           static_cast<GLsizeiptr>(count * sizeof(Instance)));
      glDrawArraysInstanced(shape.topology, 0, shape.vertices, static_cast<GLsizei>(count));
    }
    return {};
  }

 private:
  PassPrograms programs_;
  std::size_t largest_;  ///< number of instances that a texture can hold
  gl::BufferTexture texture_ = gl::BufferTexture::create();
  gl::VertexArray no_attributes_ = gl::VertexArray::create();
};

}  // namespace

std::unique_ptr<InstancingMethod> make_texture_instancing() {
  return std::make_unique<TextureInstancing>(instanced_stages("instancing/texture/fetch.glsl"));
}

}  // namespace pointreel
