#pragma once

#include <glm/glm.hpp>

#include "client/options/settings.h"

namespace pointreel {

/// The panel with the settings of the current mode, which are changed by mouse alone: the keyboard
/// stays the player's. It is in the upper left corner of a window of `size` until the user moves
/// it. To be called between Gui::begin and end. True if the user has changed the settings, which
/// stay in the ranges of the option table; closing the panel clears settings.drawing_panel.
bool drawing_panel(Settings& settings, glm::vec2 size, float scale);

}  // namespace pointreel
