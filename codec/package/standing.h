#pragma once

#include <optional>
#include <string>

#include "pointreel/geometry.h"
#include "pointreel/up.h"

namespace pointreel {

/// A warning if a capture seems to stand on a floor at 0 in another direction than `up`: the one in
/// which it is longest by far, and which begins at 0. If that is not the axis of `up`, the others
/// must reach to both sides of 0.
std::optional<std::string> standing_warning(const Box& box, Up up);

}  // namespace pointreel
