// The interface in a window of the test's own: what depends on when it is asked.

#include <cstdlib>
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

TEST_F(GuiWindow, a_drag_is_heard_of_though_the_cursor_is_shown_while_it_is_on_its_way) {
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

}  // namespace
}  // namespace pointreel::window
