#pragma once

#include <span>
#include <string_view>

#include "datasets_synthetic/body.h"

namespace pointreel {

/// The rate at which the sequences of Slomp et al., Geometry Instancing, were captured (Table I).
/// The length of a motion is given in poses at this rate.
inline constexpr double kPosesPerSecond = 30.0;

/// A movement of the figure, with a pose for any time. A movement that loops starts again after
/// seconds() without a jump. Any other movement holds its first pose before time 0 and its last
/// pose after its end.
struct Motion {
  std::string_view name;
  std::string_view summary;
  int poses;  ///< its length, at kPosesPerSecond
  bool loops;
  Pose (*pose)(double seconds);

  double seconds() const { return poses / kPosesPerSecond; }
};

/// All motions, sorted by name.
std::span<const Motion> motions();

/// The motion of that name, or nullptr.
const Motion* find_motion(std::string_view name);

/// The figure walks on the spot, a step every half second, and waves its left hand every two
/// seconds.
Pose walk(double seconds);

}  // namespace pointreel
