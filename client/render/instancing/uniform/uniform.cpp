#include <algorithm>
#include <utility>

#include "client/render/instancing/methods.h"
#include "client/render/instancing/pass_programs.h"

namespace pointreel {
namespace {

constexpr GLuint kBinding = 1;
constexpr std::size_t kBatchBytes = 65536, kBatch = kBatchBytes / sizeof(Instance);

/// Paper 2, section IV-B, "uniform buffers": batches of what fits into one.
class UniformInstancing final : public InstancingMethod {
 public:
  explicit UniformInstancing(PassPrograms programs) : programs_(std::move(programs)) {}

  void draw(const InstanceBuffer& instances, Pass pass, const PassParameters& parameters) override {
    programs_.use(pass, parameters);
    glBindVertexArray(no_attributes_.name());
    const PassTemplate shape = pass_template(pass);
    for (std::size_t first = 0; first < instances.size(); first += kBatch) {
      // Always the size of the block; parts of the ring are multiples of it.
      glBindBufferRange(GL_UNIFORM_BUFFER, kBinding, instances.name(),
                        instances.offset() + static_cast<GLintptr>(first * sizeof(Instance)),
                        kBatchBytes);
      glDrawArraysInstanced(shape.topology, 0, shape.vertices,
                            static_cast<GLsizei>(std::min(kBatch, instances.size() - first)));
    }
  }

 private:
  PassPrograms programs_;
  gl::VertexArray no_attributes_ = gl::VertexArray::create();
};

}  // namespace

Result<std::unique_ptr<InstancingMethod>> make_uniform_instancing() {
  auto programs = PassPrograms::create(instanced_stages("instancing/uniform/fetch.glsl"));
  if (!programs) return fail(programs.error().message);
  return std::make_unique<UniformInstancing>(std::move(*programs));
}

}  // namespace pointreel
