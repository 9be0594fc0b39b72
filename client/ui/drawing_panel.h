#pragma once

#include <glm/glm.hpp>

#include "client/ui/controls.h"

namespace pointreel {

/// How things are drawn, and what of it can be changed in the mode of now; by mouse alone. Between
/// Gui::begin and end, in a window of `size`, in its upper left corner until it is moved. True
/// where the user has changed the settings, which stay within what the command line takes; `open`
/// becomes false where they have closed it.
bool drawing_panel(DrawSettings& settings, bool& open, glm::vec2 size, float scale);

}  // namespace pointreel
