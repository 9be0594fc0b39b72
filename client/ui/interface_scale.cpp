#include "client/ui/interface_scale.h"

#include <algorithm>
#include <array>
#include <cmath>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace pointreel {
namespace {

/// The rows of pixels of a screen on which the interface has its usual size.
constexpr double kUsualRows = 1440.0;
constexpr std::array kScales = {0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 3.5, 4.0};
static_assert(kScales.front() == kLeastInterfaceScale && kScales.back() == kMostInterfaceScale);

/// The rows of the screen that shows the middle of the window, or of the first one; 0: unknown.
int screen_rows(GLFWwindow* window) {
  int x = 0, y = 0, width = 0, height = 0, count = 0, rows = 0;
  glfwGetWindowPos(window, &x, &y);
  glfwGetWindowSize(window, &width, &height);
  x += width / 2;
  y += height / 2;
  GLFWmonitor** const monitors = glfwGetMonitors(&count);
  for (int i = 0; i < count; ++i) {
    const GLFWvidmode* mode = glfwGetVideoMode(monitors[i]);
    int left = 0, top = 0;
    glfwGetMonitorPos(monitors[i], &left, &top);
    if (!mode) continue;
    const bool shows = x >= left && x < left + mode->width && y >= top && y < top + mode->height;
    if (shows || rows == 0) rows = mode->height;
    if (shows) break;
  }
  return rows;
}

}  // namespace

float automatic_interface_scale(float content_scale, int screen_rows) {
  // In quarters, so that text looks alike on similar screens.
  const double by_rows = std::floor(4.0 * screen_rows / kUsualRows) / 4.0;
  const double content = std::isfinite(content_scale) ? content_scale : 1.0;
  return static_cast<float>(
      std::clamp(std::max({1.0, content, by_rows}), kLeastInterfaceScale, kMostInterfaceScale));
}

float interface_scale(GLFWwindow* window, double wanted) {
  if (wanted > 0.0)
    return static_cast<float>(std::clamp(wanted, kLeastInterfaceScale, kMostInterfaceScale));
  float x = 1.0f, y = 1.0f;
  glfwGetWindowContentScale(window, &x, &y);
  return automatic_interface_scale(std::max(x, y), screen_rows(window));
}

double next_interface_scale(double scale, bool larger) {
  constexpr double kSame = 1e-3;
  if (larger) {
    const auto next = std::upper_bound(kScales.begin(), kScales.end(), scale + kSame);
    return next == kScales.end() ? kScales.back() : *next;
  }
  const auto next = std::lower_bound(kScales.begin(), kScales.end(), scale - kSame);
  return next == kScales.begin() ? kScales.front() : *(next - 1);
}

}  // namespace pointreel
