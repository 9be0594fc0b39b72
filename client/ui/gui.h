#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "client/ui/panel_textures.h"

struct GLFWcursor;
struct GLFWwindow;

namespace pointreel {

/// Dear ImGui in a window: its context, font, colours and drawing. There can be one in a process at
/// a time. The window's OpenGL context, of any version, must be current.
class Gui {
 public:
  /// Chains itself to the window's callbacks, so it must be made after everything else that has
  /// some, and destroyed before. `scale` is 1 for 96 pixels per inch, 2 for twice as many.
  Gui(GLFWwindow* window, float scale);
  ~Gui();
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;

  float scale() const { return scale_; }
  /// Takes effect when the interface is built again; not between begin() and end().
  void set_scale(float scale);
  /// Whether, when it was last built, an ImGui window that takes the mouse was at `cursor`. Windows
  /// called `but` do not count.
  bool covers(glm::dvec2 cursor, std::string_view but = {}) const;

  /// Where a mouse button is down, or was released.
  struct Held {
    glm::dvec2 cursor{0.0};
    int button = 0;  ///< GLFW's
    bool down = true;
  };

  /// Between these two, calls of ImGui's functions build the interface. Then draw() draws it, as
  /// often as the window changes. `held` replaces the current state of the mouse by an earlier one.
  void begin(const std::optional<Held>& held = {});
  void end();
  /// Something has just appeared, whose size ImGui knows only when it is built again.
  bool settling() const;
  /// Whether what was built differs from what draw() drew last.
  bool changed() const { return built_ != drawn_; }
  /// Shows or hides the mouse cursor while it is over the window.
  void show_cursor(bool shown) const;
  /// Draws over what is in the window's framebuffer. ImGui windows with the flag kOnOpaqueGround
  /// are opaque and take hardly any time while they do not change; they need OpenGL 4.5.
  void draw();

 private:
  GLFWwindow* const window_;
  GLFWcursor *const arrow_, *const no_cursor_;  ///< null: the default cursor
  float scale_;
  std::vector<std::uint64_t> built_, drawn_;  ///< checksums of ImGui's draw lists
  PanelTextures panels_;
};

}  // namespace pointreel
