#pragma once

#include "datasets_synthetic/body.h"

// The movements of the sequences in Slomp et al., Geometry Instancing, Table I, each in a file of
// its
// own; motion.h lists them. Time is in seconds from the first pose. A movement that does not loop
// holds its first pose before the start and its last pose after the end.

namespace pointreel {

Pose baseball(double seconds);
Pose basketball(double seconds);
Pose kick(double seconds);
Pose soccer_juggle(double seconds);
Pose soccer_shoot(double seconds);

}  // namespace pointreel
