#pragma once

#include <chrono>
#include <stop_token>
#include <string>

namespace pointreel {

/// Shows an error in a window until the user closes it, or until that time. For a display that
/// lacks the OpenGL version to play with; does nothing if there is no display. `ui_scale` is that
/// of the settings.
void show_error_window(const std::string& title, const std::string& message, double ui_scale,
                       std::chrono::steady_clock::time_point until, const std::stop_token& stop);

}  // namespace pointreel
