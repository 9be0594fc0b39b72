#pragma once

#include <array>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "client/ui/bindings.h"

struct GLFWwindow;

namespace pointreel {

/// What the user did since it was last asked for.
struct Input {
  std::vector<Action> actions;
  /// Drags in pixels, x to the right and y down.
  glm::dvec2 orbit{0.0}, pan{0.0};
  double wheel = 0.0;  ///< notches, positive away from the user
  /// While the time is dragged: to where, 0 at the window's left edge and 1 at its right one.
  std::optional<double> scrub;
  bool scrubbing = false;  ///< the time is being dragged
};

/// Turns a window's keys and mouse into actions. The window outlives it; one for a window.
class WindowInput {
 public:
  explicit WindowInput(GLFWwindow* window);
  ~WindowInput();
  WindowInput(const WindowInput&) = delete;
  WindowInput& operator=(const WindowInput&) = delete;

  /// Call after glfwPollEvents or glfwWaitEvents.
  Input take();

  /// Between the whole screen and the window as it was before.
  void toggle_fullscreen();

 private:
  void press(std::string_view key);
  void scrub_to(double x);

  GLFWwindow* const window_;
  Input input_;
  glm::dvec2 cursor_{0.0};
  std::array<int, 4> windowed_{};  ///< x, y, width, height before full screen
};

}  // namespace pointreel
