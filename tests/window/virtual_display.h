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

using WindowId = unsigned long;  ///< Xlib's Window; 0 is none

/// An X server without a screen: Xvfb, on a display that nobody else has. There is no window
/// manager: windows lie in the upper left corner, without a frame.
class VirtualDisplay {
 public:
  /// What has to be installed and is not: "xvfb", "xdotool"; empty where all is there.
  static std::string missing();

  static Result<std::unique_ptr<VirtualDisplay>> start(glm::ivec2 size = {1600, 1000});

  ~VirtualDisplay();

  const std::string& name() const;  ///< ":7", for DISPLAY

  /// The window that can be seen, of those of the only program that has any; 0 where there is none.
  WindowId window() const;
  std::string title(WindowId window) const;
  glm::ivec2 size(WindowId window) const;
  /// What is in the window now, as it is on the screen; empty if it is gone.
  e2e::Picture picture(WindowId window) const;
  /// Asks it to close, as a window manager does.
  void close(WindowId window) const;

  /// Gives real events: xdotool's commands and their arguments, one after the other.
  void xdotool(const std::vector<std::string>& commands) const;

  /// Drops files on the middle of a window, as a file manager does, by XDND. False if the window
  /// does not take them within ten seconds.
  bool drop(WindowId window, const std::vector<std::filesystem::path>& files) const;

 private:
  struct Server;
  explicit VirtualDisplay(std::unique_ptr<Server> server);
  std::unique_ptr<Server> server_;
};

}  // namespace pointreel::window
