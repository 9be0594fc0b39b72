#pragma once

#include <optional>
#include <string>

#include <glm/glm.hpp>

namespace pointreel {

// Texts over the picture; between Gui::begin and end, in a window of `size`.

/// A few words in the upper left corner, as of the last action.
void draw_said(const std::string& text, float scale);

/// In the middle, while something is awaited; `seconds` since when it has been.
void draw_waiting(const std::string& text, glm::vec2 size, float scale, double seconds);

/// What is wrong, in a line at the top that wraps. `hint`: what to do, below it; may be empty.
void draw_error(const std::string& text, const std::string& hint, glm::vec2 size, float scale);

/// Keys and mouse, of the table of bindings. False once the user closes it.
bool draw_help(glm::vec2 size, float scale);

}  // namespace pointreel
