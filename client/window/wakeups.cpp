#include "client/window/wakeups.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace pointreel {

void Wakeups::wake() {
  if (!posted_.exchange(true)) glfwPostEmptyEvent();
}

void Wakeups::wait(std::chrono::steady_clock::time_point until) {
  const double seconds =
      std::chrono::duration<double>(until - std::chrono::steady_clock::now()).count();
  if (seconds > 0.0)
    glfwWaitEventsTimeout(seconds);
  else
    glfwPollEvents();
  // An exchange, so that the caller sees what other threads did before they called wake().
  posted_.exchange(false);
}

}  // namespace pointreel
