#pragma once

#include <memory>

#include "client/render/opengl/instancing/method.h"
#include "client/scene/draw_options.h"

namespace pointreel {

/// Makes the method for the current OpenGL context.
std::unique_ptr<InstancingMethod> make_instancing(Instancing instancing);

}  // namespace pointreel
