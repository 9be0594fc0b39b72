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

/// Dear ImGui in a window: its context, font, colours and drawing. One at a time in a process, with
/// the window's OpenGL context current, of any version.
class Gui {
 public:
  /// Chains itself to the window's callbacks, so it is made after and destroyed before whoever
  /// else has some. `scale`: 1 for 96 pixels an inch, 2 for twice as many.
  Gui(GLFWwindow* window, float scale);
  ~Gui();
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;

  float scale() const { return scale_; }
  /// Whether a window of the gui that takes the mouse was there when it was last drawn; one
  /// that is not called `but`.
  bool covers(glm::dvec2 cursor, std::string_view but = {}) const;

  /// A button of the mouse that is down, and where.
  struct Held {
    glm::dvec2 cursor{0.0};
    int button = 0;  ///< GLFW's
  };

  /// Between these two, ImGui's functions say what there is; then draw() can draw it, as often as
  /// the window changes. `held`: the mouse as it was, where it is another by now.
  void begin(const std::optional<Held>& held = {});
  void end();
  /// Something has just appeared, and is there once its size is known: the next time.
  bool settling() const;
  /// Whether that differs from what draw() has drawn last.
  bool changed() const { return built_ != drawn_; }
  /// The mouse's cursor, over the window.
  void show_cursor(bool shown) const;
  /// Over what is in the window's framebuffer. Windows with the flag kOnOpaqueGround are opaque,
  /// and take next to no time while they do not change; these need OpenGL 4.5.
  void draw();

 private:
  GLFWwindow* const window_;
  GLFWcursor *const arrow_, *const no_cursor_;  ///< null: the display's own cursor
  float scale_;
  std::vector<std::uint64_t> built_, drawn_;  ///< numbers that stand for each of ImGui's lists
  PanelTextures panels_;
};

}  // namespace pointreel
