#pragma once

#include "client/options/settings.h"
#include "client/ui/panel_layout.h"

namespace pointreel {

/// The panel with the settings of the current mode. They are changed by mouse alone, because keys
/// control the player. It is moved to `at` if `place`, and else stays where it is. To be called
/// between Gui::begin and end. True if the user has changed the settings, which stay in the ranges
/// of the option table; closing the panel clears settings.drawing_panel.
bool drawing_panel(Settings& settings, const PanelPlace& at, bool place, float scale);

}  // namespace pointreel
