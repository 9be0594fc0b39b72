#pragma once

#include "client/scene/camera.h"
#include "client/web/wasm/module.h"

namespace pointreel {

Up up_of(double number);
double number_of(Up up);
Camera camera_of(const PrCamera& from);
void write(const Camera& from, PrCamera& to);

}  // namespace pointreel
