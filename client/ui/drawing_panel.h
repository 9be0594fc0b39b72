#pragma once

#include "client/options/settings.h"
#include "client/ui/panel_layout.h"

namespace pointreel {

/// The panel with the settings of the current mode, which are changed by mouse alone: the keyboard
/// stays the player's. Put there if `place`, otherwise where it was. To be called between
/// Gui::begin and end. True if the user has changed the settings, which stay in the ranges of the
/// option table; closing the panel clears settings.drawing_panel.
bool drawing_panel(Settings& settings, const PanelPlace& at, bool place, float scale);

}  // namespace pointreel
