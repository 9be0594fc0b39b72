#pragma once

#include "pointreel/cloud.h"

namespace pointreel {

/// A ball that turns, of 1500 coloured points; of 256 frames no two are alike.
PointCloud turning_ball(int frame);

}  // namespace pointreel
