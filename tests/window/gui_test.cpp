// The interface in a window of the test's own, for behaviour that depends on when it is called.

#include <chrono>
#include <cstdlib>
#include <optional>
#include <string>

#include <gtest/gtest.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>
#include <imgui_internal.h>

#include "client/render/opengl/gl_context.h"
#include "client/ui/interface.h"
#include "client/ui/timeline.h"
#include "client/ui/window_input.h"
#include "tests/window/window_test.h"

namespace pointreel::window::gui_test {
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
  settings.drawing_panel = false;  // there is no room for both in this corner
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

TEST_F(GuiWindow, a_click_counts_where_the_mouse_was_released_even_if_it_has_moved_on_since) {
  WindowInput input(window_->handle());
  Controls controls{{}};
  Interface interface(window_->handle(), 1.0f);
  Interface::View view;
  view.now = Interface::Now(std::chrono::seconds(100));
  view.size = {640, 480};
  const auto build = [&] { interface.build(view, controls); };
  input.set_on_button([&](glm::dvec2 cursor, int button, bool down) {
    view.held = Gui::Held{cursor, button, down};
    build();
    view.held.reset();
  });
  Settings settings;
  settings.statistics_panel = true;
  controls.set_settings(settings);
  view.statistics = {{"Shown", "30 frames/s"}};
  build();
  ASSERT_TRUE(interface.covers({600, 20}));
  // All of it arrives while the player is busy: nothing is built in between.
  display().xdotool(
      {"mousemove", "620", "18", "mousedown", "1", "mouseup", "1", "mousemove", "100", "300"});
  EXPECT_TRUE(wait_until([&] {
    glfwPollEvents();
    return input.take().cursor == glm::dvec2(100, 300);
  }));
  build();
  EXPECT_FALSE(controls.settings().statistics_panel) << "the cross in its corner was clicked";
}

TEST_F(GuiWindow, panels_do_not_cover_each_other_or_the_bar_in_a_small_window) {
  Controls controls{{}};
  Interface interface(window_->handle(), 1.0f);
  Interface::View view;
  view.now = Interface::Now(std::chrono::seconds(100));
  Settings settings;
  view.size = {640, 480};
  settings.drawing_panel = true;
  controls.set_settings(settings);
  interface.build(view, controls);
  settings.statistics_panel = true;
  controls.set_settings(settings);
  for (int i = 0; i < 16; ++i) view.statistics.push_back({"Shown", "30 frames/s, and more of it"});
  float before = 1.0f;
  for (const float scale : {1.0f, 1.5f, 1.0f}) {
    interface.set_scale(scale);
    for (const glm::vec2 size : {glm::vec2(640, 480), glm::vec2(1500, 900), glm::vec2(640, 480)}) {
      view.size = size;
      // Only after a change of the scale, ImGui learns sizes a picture late.
      for (int i = 0; i < (scale == before ? 1 : 2); ++i) interface.build(view, controls);
      before = scale;
      const ImGuiWindow* drawing = ImGui::FindWindowByName("Drawing");
      const ImGuiWindow* statistics = ImGui::FindWindowByName("Statistics");
      ASSERT_TRUE(drawing && statistics);
      EXPECT_FALSE(drawing->Rect().Overlaps(statistics->Rect())) << size.x << ", " << scale;
      for (const ImGuiWindow* panel : {drawing, statistics}) {
        EXPECT_GE(panel->Rect().Min.x, 0.0f);
        EXPECT_LE(panel->Rect().Max.x, size.x) << panel->Name << ", " << size.x << ", " << scale;
        EXPECT_LE(panel->Rect().Max.y, size.y - kTimelineHeight * scale)
            << panel->Name << ", " << size.x << ", " << scale;
      }
    }
  }
}

TEST_F(GuiWindow, the_interface_changes_its_size_while_it_is_shown) {
  Controls controls{{}};
  Settings settings;
  settings.drawing_panel = true;
  controls.set_settings(settings);
  Interface interface(window_->handle(), 1.0f);
  Interface::View view;
  view.now = Interface::Now(std::chrono::seconds(100));
  view.size = {640, 480};
  const auto width = [&] {
    for (int i = 0; i < 3; ++i) interface.build(view, controls);
    interface.draw();
    return ImGui::FindWindowByName("Drawing")->Rect().GetWidth();
  };
  const float usual = width();
  interface.set_scale(2.0f);
  EXPECT_NEAR(width(), 2.0f * usual, 0.1f * usual);
  interface.set_scale(1.0f);
  EXPECT_EQ(width(), usual);
}

}  // namespace
}  // namespace pointreel::window::gui_test
