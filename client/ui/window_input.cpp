#include "client/ui/window_input.h"

#include <algorithm>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace pointreel {

WindowInput::WindowInput(GLFWwindow* window) : window_(window) {
  glfwSetWindowUserPointer(window, this);
  glfwGetCursorPos(window, &cursor_.x, &cursor_.y);

  // Characters come by what they are, so that they work on every keyboard.
  glfwSetCharCallback(window, [](GLFWwindow* of, unsigned character) {
    auto* input = static_cast<WindowInput*>(glfwGetWindowUserPointer(of));
    if (character == ' ') {
      input->press("SPACE");
    } else if (character < 128) {
      const char text = static_cast<char>(character);
      input->press({&text, 1});
    }
  });
  glfwSetKeyCallback(window, [](GLFWwindow* of, int key, int, int action, int) {
    if (action == GLFW_RELEASE) return;
    auto* input = static_cast<WindowInput*>(glfwGetWindowUserPointer(of));
    if (key == GLFW_KEY_LEFT) input->press("LEFT");
    if (key == GLFW_KEY_RIGHT) input->press("RIGHT");
    if (key == GLFW_KEY_ESCAPE) input->press("ESC");
    if (key == GLFW_KEY_BACKSPACE) input->press("BS");
  });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* of, int button, int action, int modifiers) {
    auto* input = static_cast<WindowInput*>(glfwGetWindowUserPointer(of));
    if (button != GLFW_MOUSE_BUTTON_LEFT) return;
    input->input_.scrubbing = action == GLFW_PRESS && (modifiers & GLFW_MOD_SHIFT) != 0;
    if (input->input_.scrubbing) input->scrub_to(input->cursor_.x);
  });
  glfwSetCursorPosCallback(window, [](GLFWwindow* of, double x, double y) {
    auto* input = static_cast<WindowInput*>(glfwGetWindowUserPointer(of));
    const glm::dvec2 moved = glm::dvec2(x, y) - std::exchange(input->cursor_, glm::dvec2(x, y));
    if (input->input_.scrubbing)
      input->scrub_to(x);
    else if (glfwGetMouseButton(of, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS)
      input->input_.orbit += moved;
    else if (glfwGetMouseButton(of, GLFW_MOUSE_BUTTON_RIGHT) == GLFW_PRESS ||
             glfwGetMouseButton(of, GLFW_MOUSE_BUTTON_MIDDLE) == GLFW_PRESS)
      input->input_.pan += moved;
  });
  glfwSetScrollCallback(window, [](GLFWwindow* of, double, double notches) {
    static_cast<WindowInput*>(glfwGetWindowUserPointer(of))->input_.wheel += notches;
  });
}

WindowInput::~WindowInput() {
  glfwSetCharCallback(window_, nullptr);
  glfwSetKeyCallback(window_, nullptr);
  glfwSetMouseButtonCallback(window_, nullptr);
  glfwSetCursorPosCallback(window_, nullptr);
  glfwSetScrollCallback(window_, nullptr);
}

void WindowInput::press(std::string_view key) {
  if (const auto action = action_of(key)) input_.actions.push_back(*action);
}

void WindowInput::scrub_to(double x) {
  int width = 0, height = 0;
  glfwGetWindowSize(window_, &width, &height);
  input_.scrub = std::clamp(x / std::max(1, width), 0.0, 1.0);
}

Input WindowInput::take() {
  Input taken = std::exchange(input_, Input{});
  input_.scrubbing = taken.scrubbing;  // until the button is released
  return taken;
}

void WindowInput::toggle_fullscreen() {
  auto& [x, y, width, height] = windowed_;
  if (glfwGetWindowMonitor(window_) != nullptr) {
    glfwSetWindowMonitor(window_, nullptr, x, y, width, height, GLFW_DONT_CARE);
    return;
  }
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* mode = monitor ? glfwGetVideoMode(monitor) : nullptr;
  if (!mode) return;
  glfwGetWindowPos(window_, &x, &y);
  glfwGetWindowSize(window_, &width, &height);
  glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

}  // namespace pointreel
