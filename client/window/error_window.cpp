#include "client/window/error_window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "client/render/opengl/gl_context.h"
#include "client/ui/gui.h"
#include "client/ui/interface_scale.h"
#include "client/ui/overlay.h"
#include "client/ui/window_input.h"

namespace pointreel {

void show_error_window(const std::string& title, const std::string& message, double ui_scale,
                       std::chrono::steady_clock::time_point until, const std::stop_token& stop) {
  auto window = WindowContext::create_of_any_version(title, 800, 300);
  if (!window) return;
  WindowInput input(window->handle());
  Gui gui(window->handle(), interface_scale(window->handle(), ui_scale));
  while (!stop.stop_requested() && !glfwWindowShouldClose(window->handle()) &&
         std::chrono::steady_clock::now() < until) {
    int width = 1, height = 1;
    glfwGetWindowSize(window->handle(), &width, &height);
    gui.begin();
    draw_error(message, "Press q to quit", {width, height}, gui.scale());
    gui.end();
    window->clear({0.11f, 0.12f, 0.14f});
    gui.draw();
    window->swap();
    glfwWaitEventsTimeout(0.1);
    for (const Action action : input.take().actions)
      if (action == Action::quit || action == Action::leave) return;
  }
}

}  // namespace pointreel
