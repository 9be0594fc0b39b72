#include "client/ui/panel_layout.h"

#include "client/ui/timeline.h"

namespace pointreel {
namespace {

constexpr float kScrollbar = 14.0f;      // as in ImGuiStyle
constexpr float kMessageHeight = 48.0f;  // a few words after an action

}  // namespace

PanelLayout place_panels(glm::vec2 window, float error, float scale, glm::vec2 drawing,
                         glm::vec2 statistics) {
  const float margin = 8.0f * scale, left = 12.0f * scale;
  const float right = window.x - margin, bottom = window.y - kTimelineHeight * scale - margin;
  // A panel that gets less than its height is wider by its scroll bar.
  const auto width_in = [&](glm::vec2 size, float height) {
    return size.x + (size.y > height ? kScrollbar * scale : 0.0f);
  };
  const auto at_right = [&](float height) {
    return glm::max(right - width_in(statistics, height), margin);
  };
  const float below_words = glm::max(kMessageHeight * scale, error), top = glm::max(margin, error);
  const float left_height = glm::max(bottom - below_words, 1.0f);
  const float right_height = glm::max(bottom - top, 1.0f);
  PanelLayout layout;
  layout.drawing = {{left, below_words}, {glm::max(right - left, 1.0f), left_height}};
  layout.statistics = {{at_right(right_height), top},
                       {glm::max(right - margin, 1.0f), right_height}};
  const bool both = drawing.x > 0.0f && statistics.x > 0.0f;
  layout.stacked =
      both && left + width_in(drawing, left_height) + margin > layout.statistics.corner.x;
  if (!layout.stacked) return layout;
  // Half the height for each, unless the other one needs less.
  const float height = glm::max(left_height - margin, 2.0f);
  const float upper = glm::min(drawing.y, glm::max(0.5f * height, height - statistics.y));
  layout.drawing.most.y = upper;
  layout.statistics.corner = {at_right(height - upper), below_words + upper + margin};
  layout.statistics.most.y = height - upper;
  return layout;
}

}  // namespace pointreel
