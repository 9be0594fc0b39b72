#pragma once

#include <memory>

#include "client/render/instancing/method.h"
#include "common/base/error.h"

/// What make_instancing chooses from; each is in the folder of its name.
namespace pointreel {

Result<std::unique_ptr<InstancingMethod>> make_geometry_instancing();
Result<std::unique_ptr<InstancingMethod>> make_uniform_instancing();
Result<std::unique_ptr<InstancingMethod>> make_texture_instancing();
Result<std::unique_ptr<InstancingMethod>> make_attribute_instancing();
Result<std::unique_ptr<InstancingMethod>> make_pull_instancing();

}  // namespace pointreel
