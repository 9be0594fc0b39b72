#pragma once

#include <string>
#include <vector>

#include "client/web/wasm/module.h"
#include "pointreel/package.h"

/// A handle of module.h.
struct PrReel {
  pointreel::Manifest manifest;
  PrReelInfo info{};
  std::vector<double> times;
};

namespace pointreel {

PrReel reel_of(Manifest manifest);

}  // namespace pointreel
