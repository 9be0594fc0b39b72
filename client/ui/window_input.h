#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/ui/bindings.h"

struct GLFWwindow;

namespace pointreel {

/// What the user did since it was last asked for. Pixels are the window's, from its upper left
/// corner, x to the right and y down.
struct Input {
  bool any = false;      ///< something happened that could change what the window shows
  bool exposed = false;  ///< what the window showed is lost
  std::vector<Action> actions;
  std::optional<char> unknown;  ///< a key that does nothing, by what it types
  glm::dvec2 cursor{0.0};
  bool moved = false;               ///< the cursor
  glm::dvec2 orbit{0.0}, pan{0.0};  ///< drags, in pixels
  double wheel = 0.0;               ///< notches over the picture, positive away from the user
  /// Where the time was dragged to: 0 at the track's left end and 1 at its right one.
  std::optional<double> scrub;
  bool scrubbing = false;              ///< it still is being dragged
  std::optional<glm::dvec2> centered;  ///< a double click on the picture
  /// While flying: keys that are held, to the right, up and forward, each -1 to 1.
  glm::dvec3 fly{0.0};
  bool fast = false;                 ///< with shift
  std::vector<std::string> dropped;  ///< paths
};

/// Turns a window's keys and mouse into actions. The window outlives it; one for a window.
class WindowInput {
 public:
  /// What of the window is no picture: drags, clicks and the wheel are somebody else's there.
  using Covered = std::function<bool(glm::dvec2 cursor)>;
  /// From where to where time runs, if the cursor is on a track that can be dragged. Asked as the
  /// button goes down, so that no drag is lost, however long a picture takes.
  struct Track {
    double left = 0.0, right = 1.0;
  };
  using TrackAt = std::function<std::optional<Track>(glm::dvec2 cursor)>;

  /// Called when a button of the mouse has gone down, and before it is let go: it is down there.
  using WhileDown = std::function<void(glm::dvec2 cursor, int button)>;

  explicit WindowInput(GLFWwindow* window);
  ~WindowInput();
  WindowInput(const WindowInput&) = delete;
  WindowInput& operator=(const WindowInput&) = delete;

  void set_covered(Covered covered) { covered_ = std::move(covered); }
  void set_track(TrackAt track) { track_at_ = std::move(track); }
  void set_while_down(WhileDown call) { while_down_ = std::move(call); }
  /// W, A, S, D, E and Q are no actions, but move the camera.
  void set_flying(bool flying) { flying_ = flying; }

  /// Call after glfwPollEvents or glfwWaitEvents.
  Input take();

  /// Between the whole screen and the window as it was before.
  void toggle_fullscreen();
  bool fullscreen() const;

 private:
  bool press(std::string_view key);
  void step(double notches);
  void press_button(int button, bool shift);
  void scrub();

  GLFWwindow* const window_;
  Covered covered_;
  TrackAt track_at_;
  WhileDown while_down_;
  Input input_;
  glm::dvec2 cursor_{0.0};
  bool dragging_ = false;          ///< a button is down that went down on the picture
  std::optional<Track> scrubbed_;  ///< while the time is dragged
  bool flying_ = false;
  double stepped_ = 0.0;   ///< notches on the track that are no whole one yet
  double clicked_ = -1.0;  ///< when, in GLFW's seconds, and where
  glm::dvec2 clicked_at_{0.0};
  std::array<int, 4> windowed_{};  ///< x, y, width, height before full screen
};

}  // namespace pointreel
