#pragma once

#include <vector>

#include "client/ui/panel_layout.h"
#include "client/ui/play_statistics.h"

namespace pointreel {

/// The least width of the panel at scale 1, if there is room for it: enough for most figures, so
/// that the width does not change with each of them.
inline constexpr float kStatisticsWidth = 430.0f;

/// The panel that shows how playing goes. It is moved to `at` if `place`, and else stays where it
/// is. To be called between Gui::begin and end. False once the user closes it.
bool draw_statistics(const std::vector<StatisticsLine>& lines, const RecentFrames& recent,
                     const PanelPlace& at, bool place, float scale);

}  // namespace pointreel
