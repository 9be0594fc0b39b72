#pragma once

#include <optional>
#include <stop_token>
#include <string>

namespace pointreel {

/// A window that tells what is wrong until the user closes it, or for so many seconds: where there
/// is a display, but not the OpenGL to draw with. Does nothing where there is no display.
void show_error_window(const std::string& title, const std::string& message,
                       std::optional<double> seconds, const std::stop_token& stop);

}  // namespace pointreel
