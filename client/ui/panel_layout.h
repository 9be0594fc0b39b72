#pragma once

#include <glm/glm.hpp>

namespace pointreel {

/// Where a panel goes, and the most room that it may take, in window coordinates.
struct PanelPlace {
  glm::vec2 corner{0.0f}, most{1.0f};
};

struct PanelLayout {
  PanelPlace drawing, statistics;
  bool stacked = false;  ///< one above the other, because there is no room for both side by side
};

/// Places the panels so that neither covers the other, the bar at the bottom, or the messages in
/// the upper left corner. `error` is how far down an error across the top reaches; 0: there is
/// none. The sizes are those that the panels would like to have; zero for a panel that is closed.
/// Panels that get less room are scrolled.
PanelLayout place_panels(glm::vec2 window, float error, float scale, glm::vec2 drawing,
                         glm::vec2 statistics);

}  // namespace pointreel
