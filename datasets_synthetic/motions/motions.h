#pragma once

#include "datasets_synthetic/body.h"

// The movements of the paper's sequences (002, section V, Table I), each in a file of its own, as
// motion.h lists them. Time is in seconds from the first pose; a movement that does not loop holds
// its first and last pose.

namespace pointreel {

Pose baseball(double seconds);
Pose basketball(double seconds);
Pose kick(double seconds);
Pose soccer_juggle(double seconds);
Pose soccer_shoot(double seconds);

}  // namespace pointreel
