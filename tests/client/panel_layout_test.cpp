#include "client/ui/panel_layout.h"

#include <gtest/gtest.h>

#include "client/ui/timeline.h"

namespace pointreel::panel_layout_test {
namespace {

struct Box2 {
  glm::vec2 min, max;
};

Box2 box_of(const PanelPlace& place, glm::vec2 size) {
  return {place.corner, place.corner + glm::min(size, place.most)};
}

bool overlap(const Box2& a, const Box2& b) {
  return a.min.x < b.max.x && b.min.x < a.max.x && a.min.y < b.max.y && b.min.y < a.max.y;
}

TEST(PanelLayout, keeps_panels_apart_and_between_messages_and_bar_in_windows_of_every_size) {
  const glm::vec2 drawing(262.0f, 436.0f), statistics(430.0f, 470.0f);
  for (const float scale : {0.5f, 1.0f, 1.5f, 2.0f, 4.0f}) {
    for (const glm::vec2 window : {glm::vec2(320, 240), glm::vec2(640, 480), glm::vec2(800, 1200),
                                   glm::vec2(1280, 720), glm::vec2(3840, 2160)}) {
      const float error = window.x < 1000.0f ? 60.0f * scale : 0.0f;
      const float bottom = window.y - kTimelineHeight * scale;
      const PanelLayout layout =
          place_panels(window, error, scale, drawing * scale, statistics * scale);
      const Box2 one = box_of(layout.drawing, drawing * scale);
      const Box2 two = box_of(layout.statistics, statistics * scale);
      EXPECT_FALSE(overlap(one, two)) << window.x << ", " << scale;
      if (bottom - error < 160.0f * scale || window.x < 100.0f * scale) continue;
      for (const Box2& panel : {one, two}) {
        EXPECT_GE(panel.min.x, 0.0f) << window.x << ", " << scale;
        EXPECT_LE(panel.max.x, window.x) << window.x << ", " << scale;
        EXPECT_GE(panel.min.y, error) << window.x << ", " << scale;
        EXPECT_LE(panel.max.y, bottom) << window.x << ", " << scale;
        EXPECT_GT(panel.max.y - panel.min.y, 30.0f * scale) << window.x << ", " << scale;
      }
    }
  }
}

TEST(PanelLayout, gives_panels_all_the_room_that_they_need_where_there_is_enough) {
  const glm::vec2 drawing(262.0f, 436.0f), statistics(430.0f, 300.0f);
  const PanelLayout beside = place_panels({1280, 720}, 0.0f, 1.0f, drawing, statistics);
  EXPECT_FALSE(beside.stacked);
  EXPECT_EQ(beside.statistics.corner.x + statistics.x, 1272.0f);
  const PanelLayout above = place_panels({640, 1000}, 0.0f, 1.0f, drawing, statistics);
  EXPECT_TRUE(above.stacked);
  for (const PanelLayout& layout : {beside, above}) {
    EXPECT_GE(layout.drawing.most.y, drawing.y);
    EXPECT_GE(layout.statistics.most.y, statistics.y);
  }
  const PanelLayout alone = place_panels({640, 480}, 0.0f, 1.0f, {}, statistics);
  EXPECT_FALSE(alone.stacked);
  EXPECT_GE(alone.statistics.most.y, statistics.y);
}

}  // namespace
}  // namespace pointreel::panel_layout_test
