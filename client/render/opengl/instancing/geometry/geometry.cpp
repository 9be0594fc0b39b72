#include <utility>

#include "client/render/opengl/instancing/instance_array.h"
#include "client/render/opengl/instancing/methods.h"
#include "client/render/opengl/instancing/pass_programs.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// Slomp et al., Geometry Instancing, section IV-A. The vertex shader only forwards attributes.
class GeometryInstancing final : public InstancingMethod {
 public:
  explicit GeometryInstancing(const PassPrograms::Stages& stages) : programs_(stages) {}

  Result<void> draw(const InstanceBuffer& instances, Pass pass,
                    const PassParameters& parameters) override {
    TRY(programs_.use(pass, parameters));
    bind_instance_array(array_, instances);
    glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(instances.size()));
    return {};
  }

 private:
  PassPrograms programs_;
  gl::VertexArray array_ = make_instance_array(0);
};

std::vector<gl::Stage> stages(Pass pass, std::vector<std::string_view> primitive) {
  primitive.push_back(pass == Pass::voxel_faces ? "instancing/geometry/faces.geom.glsl"
                                                : "instancing/geometry/strip.geom.glsl");
  return {{GL_VERTEX_SHADER,
           {"instancing/shaders/instance.glsl", "instancing/attribute/fetch.glsl",
            "instancing/geometry/forward.vert.glsl"}},
          {GL_GEOMETRY_SHADER, std::move(primitive)}};
}

}  // namespace

std::unique_ptr<InstancingMethod> make_geometry_instancing() {
  return std::make_unique<GeometryInstancing>(stages);
}

}  // namespace pointreel
