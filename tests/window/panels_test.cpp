// The panels, used with the mouse, at both scales.

#include <chrono>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/window/window_test.h"

namespace pointreel::window::panels_test {
namespace {

using std::chrono::milliseconds;

/// In pixels; the first corner is inside the rectangle, the last is not.
struct Rectangle {
  glm::ivec2 first{1 << 20}, last{0};

  glm::ivec2 size() const { return last - first; }
  bool operator==(const Rectangle&) const = default;
};

/// The bounding rectangle of all pixels that differ.
Rectangle difference(const e2e::Picture& one, const e2e::Picture& other) {
  Rectangle all;
  if (one.size != other.size) return all;
  for (int y = 0; y < one.size.y; ++y) {
    for (int x = 0; x < one.size.x; ++x) {
      const std::size_t at = static_cast<std::size_t>(y * one.size.x + x);
      if (one.pixels[at] == other.pixels[at]) continue;
      all.first = glm::min(all.first, glm::ivec2(x, y));
      all.last = glm::max(all.last, glm::ivec2(x, y) + 1);
    }
  }
  return all;
}

class PanelsWindow : public WindowTest, public testing::WithParamInterface<int> {
 protected:
  /// Opens the player in point mode, paused, with nothing over the picture.
  void open_still(std::vector<std::string> arguments = {}) {
    arguments.insert(arguments.end(), {"--mode", "point", "--no-adaptive-points", "--at", "6",
                                       "--ui-scale", std::to_string(scale())});
    open(arguments);
    player().resize({1500, 900});
    pause();
    before_ = still();
    ASSERT_FALSE(before_.pixels.empty());
  }

  /// The picture, once it has not changed for a while.
  e2e::Picture still() {
    return wait_until_still([&] { return player().picture(); }, milliseconds(1200))
        .value_or(e2e::Picture{});
  }

  /// Opens a panel with its key and returns its place, where the picture has changed.
  Rectangle open_panel(const std::string& key) {
    player().key(key);
    const auto panel =
        wait_until_still([&] { return difference(before_, player().picture()); }, milliseconds(600),
                         [&](const Rectangle& seen) { return seen.size().x > 100 * scale(); });
    EXPECT_TRUE(panel);
    return panel.value_or(Rectangle{});
  }

  /// Clicks on the cross in the corner of the panel and on nothing else.
  void close_panel(const Rectangle& panel) {
    player().click({panel.last.x - 12 * scale(), panel.first.y + 10 * scale()});
    player().move_to(player().size() - 1);
    EXPECT_TRUE(wait_until([&] { return player().picture().pixels == before_.pixels; }));
  }

  int scale() const { return GetParam(); }
  double red() { return static_cast<double>(MovingPlate::plate(player().picture()).pixels); }

  e2e::Picture before_;
};

TEST_P(PanelsWindow, dragging_a_slider_of_the_drawing_panel_does_not_move_the_camera) {
  open_still();
  const int from = frame();
  const double first = red();
  const Rectangle panel = open_panel("d");
  keep("drawing panel");
  // "Point size", below the title and the modes: 1 to 16 pixels over a width of 150.
  const auto slider = [&](int x) { return panel.first + glm::ivec2(8 + x, 62) * scale(); };
  player().drag(slider(12), slider(140));
  EXPECT_TRUE(wait_until([&] { return red() > 1.2 * first; })) << red() / first;
  EXPECT_EQ(frame(), from) << "the camera must not turn";
  keep("point size dragged");
  player().drag(slider(140), slider(2));
  EXPECT_TRUE(wait_until([&] { return red() < first; })) << red() / first;
  const auto report = quit();
  EXPECT_EQ(report["window"]["camera"]["yaw"], 0.0);
  EXPECT_TRUE(report["window"]["shown"]["drawing"].get<bool>());
}

TEST_P(PanelsWindow, the_drawing_panel_is_closed_by_its_button) {
  open_still();
  close_panel(open_panel("d"));
  EXPECT_FALSE(quit()["window"]["shown"]["drawing"].get<bool>());
}

TEST_P(PanelsWindow, the_statistics_panel_is_dragged_by_its_title_and_closed_by_its_button) {
  open_still();
  const Rectangle panel = open_panel("i");
  keep("statistics panel");
  const glm::ivec2 title = panel.first + glm::ivec2(100, 10) * scale(), by(-200, 40);
  player().drag(title, title + by);
  Rectangle moved;
  EXPECT_TRUE(wait_until([&] {
    moved = difference(before_, player().picture());
    return moved.first == panel.first + by && moved.size() == panel.size();
  })) << moved.first.x - panel.first.x
      << ", " << moved.size().x - panel.size().x;
  close_panel(moved);
  const auto report = quit();
  EXPECT_EQ(report["window"]["camera"]["yaw"], 0.0);
  EXPECT_FALSE(report["window"]["shown"]["statistics"].get<bool>());
}

INSTANTIATE_TEST_SUITE_P(Scales, PanelsWindow, testing::Values(1, 2));

}  // namespace
}  // namespace pointreel::window::panels_test
