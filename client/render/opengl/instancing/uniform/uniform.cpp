#include <algorithm>
#include <utility>

#include "client/render/opengl/instancing/methods.h"
#include "client/render/opengl/instancing/pass_programs.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr GLuint kBinding = 1;
constexpr std::size_t kBatchBytes = 65536, kBatch = kBatchBytes / sizeof(Instance);

/// Slomp et al., Geometry Instancing, section IV-B, "uniform buffers". Each draw call takes as many
/// instances as fit into a uniform buffer.
class UniformInstancing final : public InstancingMethod {
 public:
  explicit UniformInstancing(const PassPrograms::Stages& stages) : programs_(stages) {}

  Result<void> draw(const InstanceBuffer& instances, Pass pass,
                    const PassParameters& parameters) override {
    TRY(programs_.use(pass, parameters));
    glBindVertexArray(no_attributes_.name());
    const PassTemplate shape = pass_template(pass);
    for (std::size_t first = 0; first < instances.size(); first += kBatch) {
      // The range must be as large as the shader's block. InstanceBuffer has whole blocks.
      glBindBufferRange(GL_UNIFORM_BUFFER, kBinding, instances.name(),
                        static_cast<GLintptr>(first * sizeof(Instance)), kBatchBytes);
      glDrawArraysInstanced(shape.topology, 0, shape.vertices,
                            static_cast<GLsizei>(std::min(kBatch, instances.size() - first)));
    }
    return {};
  }

 private:
  PassPrograms programs_;
  gl::VertexArray no_attributes_ = gl::VertexArray::create();
};

}  // namespace

std::unique_ptr<InstancingMethod> make_uniform_instancing() {
  return std::make_unique<UniformInstancing>(instanced_stages("instancing/uniform/fetch.glsl"));
}

}  // namespace pointreel
