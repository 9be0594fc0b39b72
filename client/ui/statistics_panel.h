#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "client/ui/play_statistics.h"

namespace pointreel {

/// The panel that shows how playing goes, in the upper right corner of a window of `size`. To be
/// called between Gui::begin and end. False once the user closes it.
bool draw_statistics(const std::vector<StatisticsLine>& lines, const RecentFrames& recent,
                     glm::vec2 size, float scale);

}  // namespace pointreel
