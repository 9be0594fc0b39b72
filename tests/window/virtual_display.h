#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "pointreel/error.h"
#include "tests/e2e/picture.h"

namespace pointreel::window {

using WindowId = unsigned long;  ///< Xlib's Window; 0 means none

/// An X server without a screen: Xvfb, on a display that nobody else uses. There is no window
/// manager: windows lie in the upper left corner and have no frame.
class VirtualDisplay {
 public:
  /// The names of required programs that are not installed: "xvfb", "xdotool". Empty if none is
  /// missing.
  static std::string missing();

  static Result<std::unique_ptr<VirtualDisplay>> start(glm::ivec2 size = {1600, 1000});

  ~VirtualDisplay();

  const std::string& name() const;  ///< for DISPLAY, such as ":7"

  /// The visible window of the only program that has any, or 0 if there is none.
  WindowId window() const;
  std::string title(WindowId window) const;
  glm::ivec2 size(WindowId window) const;
  /// The current contents of the window as on the screen. Empty if the window is gone.
  e2e::Picture picture(WindowId window) const;
  /// Asks the window to close, as a window manager does.
  void close(WindowId window) const;

  /// Generates real events: xdotool's commands and their arguments, one after the other.
  void xdotool(const std::vector<std::string>& commands) const;

  /// Drops files on the middle of a window by XDND, as a file manager does. Returns false if the
  /// window does not accept them within ten seconds.
  bool drop(WindowId window, const std::vector<std::filesystem::path>& files) const;

 private:
  struct Server;
  explicit VirtualDisplay(std::unique_ptr<Server> server);
  std::unique_ptr<Server> server_;
};

}  // namespace pointreel::window
