#pragma once

#include <span>
#include <string_view>

#include "datasets_synthetic/body.h"

namespace pointreel {

/// Motions are as long as so many poses at this rate, that of the paper's sequences (002, section
/// V, Table I).
inline constexpr double kPosesPerSecond = 30.0;

/// A movement, defined at any time. One that loops begins again after seconds() without a jump;
/// another holds its first pose before it and its last pose after it.
struct Motion {
  std::string_view name;
  std::string_view summary;
  int poses;  ///< at kPosesPerSecond
  bool loops;
  Pose (*pose)(double seconds);

  double seconds() const { return poses / kPosesPerSecond; }
};

/// All motions there are, by name.
std::span<const Motion> motions();

/// The motion of that name, or nullptr.
const Motion* find_motion(std::string_view name);

/// Walks on the spot, a step every half second, and waves its left hand once in two seconds.
Pose walk(double seconds);

}  // namespace pointreel
