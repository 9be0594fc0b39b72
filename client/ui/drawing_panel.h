#pragma once

#include <span>
#include <string>

#include "client/options/settings.h"
#include "client/ui/panel_layout.h"

namespace pointreel {

/// The panel with the settings of the current mode. They are changed by mouse alone, because keys
/// control the player. `fields`: the scalar fields that may be shown. It is moved to `at` if
/// `place`, and else stays where it is. To be called between Gui::begin and end. True if the user
/// has changed the settings, which stay in the ranges of the option table; closing the panel clears
/// settings.drawing_panel.
bool drawing_panel(Settings& settings, std::span<const std::string> fields, const PanelPlace& at,
                   bool place, float scale);

}  // namespace pointreel
