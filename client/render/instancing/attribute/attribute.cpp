#include <utility>

#include "client/render/instancing/instance_array.h"
#include "client/render/instancing/methods.h"
#include "client/render/instancing/pass_programs.h"

namespace pointreel {
namespace {

/// Paper 2, section IV-B, "regular vertex buffers".
class AttributeInstancing final : public InstancingMethod {
 public:
  explicit AttributeInstancing(PassPrograms programs) : programs_(std::move(programs)) {}

  void draw(const InstanceBuffer& instances, Pass pass, const PassParameters& parameters) override {
    programs_.use(pass, parameters);
    bind_instance_array(array_, instances);
    const PassTemplate shape = pass_template(pass);
    glDrawArraysInstanced(shape.topology, 0, shape.vertices,
                          static_cast<GLsizei>(instances.size()));
  }

 private:
  PassPrograms programs_;
  gl::VertexArray array_ = make_instance_array(1);
};

}  // namespace

Result<std::unique_ptr<InstancingMethod>> make_attribute_instancing() {
  auto programs = PassPrograms::create(instanced_stages("instancing/attribute/fetch.glsl"));
  if (!programs) return fail(programs.error().message);
  return std::make_unique<AttributeInstancing>(std::move(*programs));
}

}  // namespace pointreel
