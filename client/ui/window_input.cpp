#include "client/ui/window_input.h"

#include <algorithm>
#include <string_view>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace pointreel {
namespace {

constexpr double kDoubleClick = 0.35;                  ///< seconds
constexpr double kDoubleClickPixels = 5.0;             ///< at most this far apart
constexpr std::string_view kFlyKeys = "wasdeqWASDEQ";  // as in Rerun

WindowInput& of(GLFWwindow* window) {
  return *static_cast<WindowInput*>(glfwGetWindowUserPointer(window));
}

std::string_view key_name(int key, bool shift) {
  switch (key) {
    case GLFW_KEY_LEFT:
      return shift ? "Shift+LEFT" : "LEFT";
    case GLFW_KEY_RIGHT:
      return shift ? "Shift+RIGHT" : "RIGHT";
    case GLFW_KEY_UP:
      return "UP";
    case GLFW_KEY_DOWN:
      return "DOWN";
    case GLFW_KEY_PAGE_UP:
      return "PGUP";
    case GLFW_KEY_PAGE_DOWN:
      return "PGDWN";
    case GLFW_KEY_HOME:
      return "HOME";
    case GLFW_KEY_END:
      return "END";
    case GLFW_KEY_F1:
      return "F1";
    case GLFW_KEY_F11:
      return "F11";
    case GLFW_KEY_BACKSPACE:
      return "BACKSPACE";
    case GLFW_KEY_TAB:
      return "TAB";
    case GLFW_KEY_ESCAPE:
      return "ESC";
    default:
      return {};
  }
}

}  // namespace

WindowInput::WindowInput(GLFWwindow* window) : window_(window) {
  glfwSetWindowUserPointer(window, this);
  glfwGetCursorPos(window, &cursor_.x, &cursor_.y);

  // Characters, not key codes, so that the keys work on every keyboard layout.
  glfwSetCharCallback(window, [](GLFWwindow* w, unsigned character) {
    if (character == ' ') {
      of(w).press("SPACE");
    } else if (character < 128) {
      const char text = static_cast<char>(character);
      if (of(w).flying_ && kFlyKeys.find(text) != std::string_view::npos) return;
      if (!of(w).press({&text, 1})) of(w).input_.unknown = text;
    }
  });
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int modifiers) {
    of(w).input_.any = true;
    if (action == GLFW_RELEASE) return;
    of(w).press(key_name(key, (modifiers & GLFW_MOD_SHIFT) != 0));
  });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int modifiers) {
    WindowInput& self = of(w);
    self.input_.any = true;
    if (action == GLFW_PRESS) {
      self.press_button(button, (modifiers & GLFW_MOD_SHIFT) != 0);
      if (self.on_button_) self.on_button_(self.cursor_, button, true);
    } else {
      // The cursor may move on before the interface is built the next time, and a button of it is
      // pressed only where the mouse is released.
      for (const bool down : {true, false})
        if (self.on_button_) self.on_button_(self.cursor_, button, down);
      self.dragging_ = false;
      self.scrubbed_.reset();
    }
  });
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) {
    WindowInput& self = of(w);
    self.input_.any = self.input_.moved = true;
    const glm::dvec2 moved = glm::dvec2(x, y) - std::exchange(self.cursor_, glm::dvec2(x, y));
    if (self.scrubbed_) self.scrub();
    if (!self.dragging_) return;
    if (glfwGetMouseButton(w, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS)
      self.input_.orbit += moved;
    else
      self.input_.pan += moved;
  });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double, double notches) {
    WindowInput& self = of(w);
    self.input_.any = true;
    if (self.track_at_ && self.track_at_(self.cursor_))
      self.step(notches);
    else if (!self.covered_ || !self.covered_(self.cursor_))
      self.input_.wheel += notches;
  });
  glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
    of(w).input_.any = true;
    of(w).input_.dropped.assign(paths, paths + count);
  });
  glfwSetWindowRefreshCallback(
      window, [](GLFWwindow* w) { of(w).input_.any = of(w).input_.exposed = true; });
}

WindowInput::~WindowInput() {
  glfwSetCharCallback(window_, nullptr);
  glfwSetKeyCallback(window_, nullptr);
  glfwSetMouseButtonCallback(window_, nullptr);
  glfwSetCursorPosCallback(window_, nullptr);
  glfwSetScrollCallback(window_, nullptr);
  glfwSetDropCallback(window_, nullptr);
  glfwSetWindowRefreshCallback(window_, nullptr);
}

bool WindowInput::press(std::string_view key) {
  input_.any = true;
  const auto action = action_of(key);
  // What the next key means must not depend on whether it comes in the same round.
  if (action == Action::toggle_fly) flying_ = !flying_;
  if (action) input_.actions.push_back(*action);
  return action.has_value();
}

/// The wheel over the track steps forward if it is turned away from the user, as in mpv.
void WindowInput::step(double notches) {
  stepped_ += notches;
  for (; stepped_ >= 1.0; stepped_ -= 1.0) input_.actions.push_back(Action::step_forward);
  for (; stepped_ <= -1.0; stepped_ += 1.0) input_.actions.push_back(Action::step_back);
}

void WindowInput::press_button(int button, bool shift) {
  const bool left = button == GLFW_MOUSE_BUTTON_LEFT;
  if (left && track_at_) scrubbed_ = track_at_(cursor_);
  if (!scrubbed_ && covered_ && covered_(cursor_)) return;
  if (!scrubbed_ && left && shift) {
    int width = 0, height = 0;
    glfwGetWindowSize(window_, &width, &height);
    scrubbed_ = Track{0.0, static_cast<double>(width)};
  }
  if (scrubbed_) {
    scrub();
    return;
  }
  dragging_ = true;
  if (!left) return;
  const double now = glfwGetTime();
  const bool twice = clicked_ >= 0.0 && now - clicked_ < kDoubleClick &&
                     glm::distance(cursor_, clicked_at_) < kDoubleClickPixels;
  if (twice) input_.centered = cursor_;
  clicked_ = twice ? -1.0 : now;
  clicked_at_ = cursor_;
}

void WindowInput::scrub() {
  const double width = std::max(1.0, scrubbed_->right - scrubbed_->left);
  input_.scrub = std::clamp((cursor_.x - scrubbed_->left) / width, 0.0, 1.0);
}

Input WindowInput::take() {
  Input taken = std::exchange(input_, Input{});
  taken.cursor = cursor_;
  taken.scrubbing = scrubbed_.has_value();
  if (!flying_) return taken;
  const auto held = [this](int key) { return glfwGetKey(window_, key) == GLFW_PRESS ? 1.0 : 0.0; };
  taken.fly = {held(GLFW_KEY_D) - held(GLFW_KEY_A), held(GLFW_KEY_E) - held(GLFW_KEY_Q),
               held(GLFW_KEY_W) - held(GLFW_KEY_S)};
  taken.fast = held(GLFW_KEY_LEFT_SHIFT) + held(GLFW_KEY_RIGHT_SHIFT) > 0.0;
  return taken;
}

bool WindowInput::fullscreen() const { return glfwGetWindowMonitor(window_) != nullptr; }

void WindowInput::toggle_fullscreen() {
  auto& [x, y, width, height] = windowed_;
  if (fullscreen()) {
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
