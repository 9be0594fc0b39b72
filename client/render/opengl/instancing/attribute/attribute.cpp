#include <utility>

#include "client/render/opengl/instancing/instance_array.h"
#include "client/render/opengl/instancing/methods.h"
#include "client/render/opengl/instancing/pass_programs.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// Slomp et al., Geometry Instancing, section IV-B, "regular vertex buffers".
class AttributeInstancing final : public InstancingMethod {
 public:
  explicit AttributeInstancing(const PassPrograms::Stages& stages) : programs_(stages) {}

  Result<void> draw(const InstanceBuffer& instances, Pass pass,
                    const PassParameters& parameters) override {
    TRY(programs_.use(pass, parameters));
    bind_instance_array(array_, instances);
    const PassTemplate shape = pass_template(pass);
    glDrawArraysInstanced(shape.topology, 0, shape.vertices,
                          static_cast<GLsizei>(instances.size()));
    return {};
  }

 private:
  PassPrograms programs_;
  gl::VertexArray array_ = make_instance_array(1);
};

}  // namespace

std::unique_ptr<InstancingMethod> make_attribute_instancing() {
  return std::make_unique<AttributeInstancing>(instanced_stages("instancing/attribute/fetch.glsl"));
}

}  // namespace pointreel
