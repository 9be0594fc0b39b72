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

struct HelpUse {
  bool open = true;      ///< false once it is closed
  bool scrolls = false;  ///< there is more than the window has room for
};
/// Keys and mouse, of the table of bindings; first scrolled by so many lines, down is positive.
HelpUse draw_help(glm::vec2 size, float scale, int lines_down);

}  // namespace pointreel
