#pragma once

#include "client/render/region.h"
#include "client/web/wasm/module.h"

namespace pointreel {

InstanceBounds bounds_of(const PrBounds& from);

}  // namespace pointreel
