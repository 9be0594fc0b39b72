#pragma once

#include <span>
#include <string_view>

#include "datasets_synthetic/body.h"

namespace pointreel {

/// A movement that begins again after `period` seconds without a jump.
struct Motion {
  std::string_view name;
  std::string_view summary;
  double period;
  Pose (*pose)(double seconds);
};

/// All motions there are, by name.
std::span<const Motion> motions();

/// The motion of that name, or nullptr.
const Motion* find_motion(std::string_view name);

/// Walks on the spot, a step every half second, and waves its left hand once in two seconds.
Pose walk(double seconds);

}  // namespace pointreel
