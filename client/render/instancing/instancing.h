#pragma once

#include <memory>

#include "client/render/instancing/method.h"

namespace pointreel {

/// How instances become triangles. The first four are those that paper 2, section IV, compares.
enum class Instancing {
  geometry,   ///< a geometry shader expands points
  uniform,    ///< hardware instancing; instances in uniform buffers, 64 KiB a draw call
  texture,    ///< hardware instancing; instances in a texture buffer
  attribute,  ///< hardware instancing; instances as vertex attributes ("regular vertex buffers")
  pull,       ///< what can be seen is listed first, and only that is expanded
};

/// For the current context.
std::unique_ptr<InstancingMethod> make_instancing(Instancing instancing);

inline constexpr int kInstancings = 5;

/// The one after it, in turn.
Instancing next(Instancing instancing);

/// "geometry", "uniform", "texture", "attribute", "pull".
const char* name(Instancing instancing);

}  // namespace pointreel
