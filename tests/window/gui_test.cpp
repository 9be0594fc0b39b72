// The interface in a window of the test's own, for behaviour that depends on when it is called.

#include <chrono>
#include <cstdlib>
#include <optional>
#include <string>

#include <gtest/gtest.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "client/render/gl_context.h"
#include "client/ui/interface.h"
#include "client/ui/window_input.h"
#include "tests/window/window_test.h"

namespace pointreel::window {
namespace {

class GuiWindow : public WindowTest {
 protected:
  void SetUp() override {
    WindowTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    ::setenv("DISPLAY", display().name().c_str(), 1);
    auto window = WindowContext::create("Pointreel", 640, 480);
    ASSERT_TRUE(window) << window.error().message;
    window_.emplace(*std::move(window));
  }

  std::optional<WindowContext> window_;
};

TEST_F(GuiWindow, a_drag_is_received_while_the_cursor_reappears) {
  WindowInput input(window_->handle());
  const Gui gui(window_->handle(), 1.0f);
  const auto next_input = [&] {
    glfwPollEvents();
    return input.take();
  };
  gui.show_cursor(false);
  display().xdotool({"mousemove", "100", "100"});
  ASSERT_TRUE(wait_until([&] { return next_input().cursor.x == 100.0; }));

  display().xdotool({"mousedown", "1", "mousemove", "250", "100", "mouseup", "1"});
  gui.show_cursor(true);
  double turned = 0.0;
  EXPECT_TRUE(wait_until([&] { return (turned += next_input().orbit.x) == 150.0; })) << turned;
}

TEST_F(GuiWindow, help_and_panels_appear_when_they_are_first_built) {
  Controls controls{{}};
  Interface interface(window_->handle(), 1.0f);
  Interface::View view;
  view.size = {640, 480};
  const glm::dvec2 middle(320, 240), drawing(40, 60), statistics(600, 20);
  const auto build = [&] {
    view.now += std::chrono::milliseconds(33);
    interface.build(view, controls);
  };
  build();
  EXPECT_FALSE(interface.covers(middle));
  controls.show_help = true;
  build();
  EXPECT_TRUE(interface.covers(middle));
  controls.show_help = false;
  build();
  EXPECT_FALSE(interface.covers(middle) || interface.covers(drawing) ||
               interface.covers(statistics));
  Settings settings;
  settings.drawing_panel = true;
  controls.set_settings(settings);
  build();
  EXPECT_TRUE(interface.covers(drawing));
  settings.statistics_panel = true;
  controls.set_settings(settings);
  view.statistics = {{"Shown", "30 frames/s"}};
  build();
  EXPECT_TRUE(interface.covers(statistics));
}

TEST_F(GuiWindow, help_longer_than_the_window_is_scrolled_by_the_seek_keys) {
  Controls controls{{}};
  Interface interface(window_->handle(), 1.0f);
  Interface::View view;
  view.now = Interface::Now(std::chrono::seconds(100));
  const auto build = [&](glm::vec2 size) {
    view.size = size;
    interface.build(view, controls);
    interface.build(view, controls);
  };
  EXPECT_FALSE(interface.scroll_help(Action::seek_back_far)) << "the help is not shown yet";
  controls.show_help = true;
  build({1280, 720});
  EXPECT_FALSE(interface.scroll_help(Action::seek_back_far)) << "all of the help is visible";
  build({420, 400});
  interface.draw();
  EXPECT_FALSE(interface.changed());
  EXPECT_FALSE(interface.scroll_help(Action::toggle_play));
  for (const Action down : {Action::seek_back_far, Action::seek_back_tenth}) {
    EXPECT_TRUE(interface.scroll_help(down));
    build({420, 400});
    EXPECT_TRUE(interface.changed());
    interface.draw();
  }
  for (const Action up : {Action::seek_forward_far, Action::seek_forward_tenth})
    EXPECT_TRUE(interface.scroll_help(up));
  build({420, 400});
  EXPECT_TRUE(interface.changed());
  controls.show_help = false;
  build({420, 400});
  EXPECT_FALSE(interface.scroll_help(Action::seek_back_far)) << "the help is closed";
}

}  // namespace
}  // namespace pointreel::window
