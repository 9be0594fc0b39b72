#pragma once

#include <memory>

#include "client/render/opengl/instancing/method.h"

/// The methods that make_instancing chooses from. Each is in the folder of its name.
namespace pointreel {

std::unique_ptr<InstancingMethod> make_geometry_instancing();
std::unique_ptr<InstancingMethod> make_uniform_instancing();
std::unique_ptr<InstancingMethod> make_texture_instancing();
std::unique_ptr<InstancingMethod> make_attribute_instancing();
std::unique_ptr<InstancingMethod> make_pull_instancing();

}  // namespace pointreel
