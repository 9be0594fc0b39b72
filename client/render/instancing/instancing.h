#pragma once

#include <memory>

#include "client/render/instancing/method.h"
#include "client/scene/draw_options.h"

namespace pointreel {

/// For the current context.
std::unique_ptr<InstancingMethod> make_instancing(Instancing instancing);

}  // namespace pointreel
