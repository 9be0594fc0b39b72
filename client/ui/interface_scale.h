#pragma once

struct GLFWwindow;

namespace pointreel {

/// The smallest and largest size of the interface that a user can choose.
inline constexpr double kLeastInterfaceScale = 0.5, kMostInterfaceScale = 4.0;

/// The size of the interface on a screen that wants text of this scale and has this many rows of
/// pixels (0: unknown), where 1 is for 96 pixels per inch. Many displays with 4K screens do not
/// tell that they want larger text, so these get one and a half of the usual size, and larger
/// screens accordingly more.
float automatic_interface_scale(float content_scale, int screen_rows);

/// The size of the interface in a window: the `wanted` one, or if that is 0, the automatic one for
/// the screen that shows the middle of the window.
float interface_scale(GLFWwindow* window, double wanted);

/// The next larger or smaller size that a key chooses.
double next_interface_scale(double scale, bool larger);

}  // namespace pointreel
