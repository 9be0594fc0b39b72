#pragma once

#include "pointreel/cloud.h"

namespace pointreel {

/// A turning ball of 1500 coloured points. Of 256 frames, no two are equal.
PointCloud turning_ball(int frame);

}  // namespace pointreel
