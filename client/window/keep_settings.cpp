#include "client/window/keep_settings.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "client/options/settings_file.h"

namespace pointreel {

Result<void> keep_settings(const PlayOptions& options, Settings settings,
                           const WindowContext& window, const WindowInput& input) {
  if (options.settings_file.empty()) return {};
  if (!input.fullscreen()) glfwGetWindowSize(window.handle(), &settings.size.x, &settings.size.y);
  return write_settings(options.settings_file, options.settings, settings);
}

}  // namespace pointreel
