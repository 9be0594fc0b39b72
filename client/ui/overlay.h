#pragma once

#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "client/scene/legend.h"

namespace pointreel {

// Texts over the picture, in a window of `size`. To be called between Gui::begin and end.

/// A few words in the upper left corner, for instance about the last action.
void draw_said(const std::string& text, float scale);

/// A text with a turning circle in the middle, for something that has been awaited for `seconds`.
void draw_waiting(const std::string& text, glm::vec2 size, float scale, double seconds);

/// What the colours mean, above and to the right of `corner`.
void draw_legend(const Legend& legend, glm::vec2 corner, float scale);

/// An error at the top, in lines that wrap, and below it a hint what to do, which may be empty.
/// Returns how far down it reaches, with a margin.
float draw_error(const std::string& text, const std::string& hint, glm::vec2 size, float scale);

struct HelpUse {
  bool open = true;      ///< false once it is closed
  bool scrolls = false;  ///< it is longer than the window
};
/// The keys and the mouse, from the table of bindings, after scrolling down by `lines_down` lines.
HelpUse draw_help(glm::vec2 size, float scale, int lines_down);

}  // namespace pointreel
