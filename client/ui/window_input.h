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

/// What the user did since the last call of WindowInput::take(). Pixels are those of the window,
/// from its upper left corner, x to the right and y down.
struct Input {
  bool any = false;      ///< something happened that could change what the window shows
  bool exposed = false;  ///< the window has lost its content
  std::vector<Action> actions;
  std::optional<char> unknown;  ///< the character of a key that does nothing
  glm::dvec2 cursor{0.0};
  bool moved = false;               ///< the cursor
  glm::dvec2 orbit{0.0}, pan{0.0};  ///< drags, in pixels
  double wheel = 0.0;               ///< notches over the picture, positive away from the user
  /// The point to which the time was dragged: 0 at the left end of the track, 1 at its right end.
  std::optional<double> scrub;
  bool scrubbing = false;              ///< the time is still being dragged
  std::optional<glm::dvec2> centered;  ///< a double click on the picture
  /// While flying, the direction of the keys that are held: right, up and forward, each -1 to 1.
  glm::dvec3 fly{0.0};
  bool fast = false;                 ///< shift is held
  std::vector<std::string> dropped;  ///< paths
};

/// Turns the keys and the mouse of a window into actions. There is one for each window, which must
/// outlive it.
class WindowInput {
 public:
  /// Whether the interface covers the picture at this point. Drags, clicks and the wheel are not
  /// for the picture there.
  using Covered = std::function<bool(glm::dvec2 cursor)>;
  /// The ends of the track on which the time can be dragged, if the cursor is on it. Asked as soon
  /// as the button goes down, so that no drag is lost, however long a picture takes.
  struct Track {
    double left = 0.0, right = 1.0;
  };
  using TrackAt = std::function<std::optional<Track>(glm::dvec2 cursor)>;

  /// Called when a mouse button goes down, again just before it is released, while it still counts
  /// as down at `cursor`, and once more when it has been released there.
  using OnButton = std::function<void(glm::dvec2 cursor, int button, bool down)>;

  explicit WindowInput(GLFWwindow* window);
  ~WindowInput();
  WindowInput(const WindowInput&) = delete;
  WindowInput& operator=(const WindowInput&) = delete;

  void set_covered(Covered covered) { covered_ = std::move(covered); }
  void set_track(TrackAt track) { track_at_ = std::move(track); }
  void set_on_button(OnButton call) { on_button_ = std::move(call); }
  /// While flying, W, A, S, D, E and Q move the camera and are not actions.
  void set_flying(bool flying) { flying_ = flying; }

  /// To be called after glfwPollEvents or glfwWaitEvents.
  Input take();

  /// Switches between the full screen and the window as it was before.
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
  OnButton on_button_;
  Input input_;
  glm::dvec2 cursor_{0.0};
  bool dragging_ = false;          ///< a button went down on the picture and is still down
  std::optional<Track> scrubbed_;  ///< the track on which the time is being dragged
  bool flying_ = false;
  double stepped_ = 0.0;   ///< part of a notch over the track that is not complete yet
  double clicked_ = -1.0;  ///< time of the last click by GLFW's clock; negative: none
  glm::dvec2 clicked_at_{0.0};
  std::array<int, 4> windowed_{};  ///< x, y, width, height before full screen
};

}  // namespace pointreel
