#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "client/playback/statistics.h"
#include "client/render/opengl/gl_context.h"
#include "client/ui/controls.h"
#include "client/ui/interface.h"
#include "client/ui/play_statistics.h"
#include "client/window/thumbnail_painter.h"
#include "client/window/window_errors.h"
#include "client/window/window_session.h"

namespace pointreel {

/// The interface of the player's window: what it shows of the session, and when it is built again.
class WindowInterface {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// All arguments must outlive it. It chains itself to the callbacks of WindowInput, which must
  /// therefore be made before.
  WindowInterface(WindowContext& window, const WindowSession& session, const WindowErrors& errors,
                  Controls& controls);

  /// Requests a few builds, because something has happened.
  void refresh();
  /// Requests one more build, because what it shows has changed.
  void refresh_once();
  /// When it is to be built again; none: not before something happens.
  std::optional<TimePoint> next_build() const;

  void build(TimePoint now) { build(now, std::nullopt); }
  /// When a button of the mouse goes down or up, so that panels see each press and each whole drag,
  /// however long a picture takes.
  void build_for_button(glm::dvec2 cursor, int button, bool down);
  /// Builds it if it shows something else than what the user waits for now.
  void update_waiting(TimePoint now);
  /// Draws into the window's framebuffer. If `timed`, waits for OpenGL and counts the time.
  void draw(bool timed);

  /// The buttons of the bar that were pressed since the last call.
  std::vector<Action> take_pressed() { return std::exchange(pressed_, {}); }
  /// Something else plays.
  void forget();

  Interface& parts() { return interface_; }
  RecentFrames& recent() { return recent_; }
  /// The error that it shows; empty: none.
  const std::string& error() const { return view_.error; }
  /// To build and draw it, of each picture that it was on.
  const TimeSamples& times() const { return times_; }

 private:
  void build(TimePoint now, const std::optional<Gui::Held>& held);
  void update_scale(TimePoint now);
  void update_statistics(TimePoint now);
  std::optional<Thumbnail> thumbnail();

  WindowContext& window_;
  const WindowSession& session_;
  const WindowErrors& errors_;
  Controls& controls_;
  Interface interface_;
  Interface::View view_;
  ThumbnailPainter thumbnails_;
  RecentFrames recent_;
  std::optional<std::uint64_t> hovered_us_;  ///< the time under the cursor
  std::vector<Action> pressed_;
  int builds_due_ = 0;
  TimePoint built_{}, statistics_updated_{}, scale_updated_{};
  double wanted_scale_ = 0.0;
  double build_ms_ = 0.0;  ///< since it was drawn last
  TimeSamples times_;
};

}  // namespace pointreel
