#include "client/render/opengl/instancing/instancing.h"

#include "client/render/opengl/instancing/methods.h"

namespace pointreel {

std::unique_ptr<InstancingMethod> make_instancing(Instancing instancing) {
  switch (instancing) {
    case Instancing::geometry:
      return make_geometry_instancing();
    case Instancing::uniform:
      return make_uniform_instancing();
    case Instancing::texture:
      return make_texture_instancing();
    case Instancing::attribute:
      return make_attribute_instancing();
    case Instancing::pull:
      return make_pull_instancing();
  }
  return nullptr;
}

}  // namespace pointreel
