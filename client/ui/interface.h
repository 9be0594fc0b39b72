#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/ui/controls.h"
#include "client/ui/gui.h"
#include "client/ui/play_statistics.h"
#include "client/ui/timeline.h"

struct GLFWwindow;

namespace pointreel {

/// Everything that is drawn over the picture, and when it is there: the bar while the mouse moves,
/// panels and help while the user wants them, a few words after an action, what is wrong while it
/// is.
class Interface {
 public:
  using Now = Controls::Now;

  struct View {
    Now now;
    glm::vec2 size{1.0f};  ///< of the window, in its own coordinates
    std::string waiting;   ///< what for; empty: for nothing
    double waiting_seconds = 0.0;
    std::string error, hint;                 ///< draw_error's; empty: all is well
    std::optional<TimelineView> timeline;    ///< of what plays
    std::vector<StatisticsLine> statistics;  ///< while Controls::show_statistics
    RecentFrames recent;                     ///< the same
    std::optional<Thumbnail> thumbnail;      ///< for TimelineUse::hovered_us of the last build
    std::optional<Gui::Held> held;           ///< Gui::begin's
  };

  Interface(GLFWwindow* window, float scale) : gui_(window, scale) {}

  float scale() const { return gui_.scale(); }

  /// The mouse moved: the bar is there for a moment.
  void wake(Now now) { awake_ = now; }
  void say(const std::string& text, Now now);

  /// The help, where it is there and longer than the window, is scrolled by the keys that go to
  /// other times otherwise. False: that is no such key, or there is no such help.
  bool scroll_help(Action action);

  /// What the window shows there is not the picture.
  bool covers(glm::dvec2 cursor) const;
  /// The bar's track, if the cursor is on it.
  std::optional<TrackArea> track_at(glm::dvec2 cursor) const;
  /// It changes by itself: build it again soon.
  bool changing(const View& view) const;

  /// What there is, which draw() draws, and what the user does to it.
  TimelineUse build(const View& view, Controls& controls);
  /// Whether that differs from what draw() has drawn last.
  bool changed() const { return gui_.changed(); }
  /// Into the window's framebuffer.
  void draw();
  bool empty() const { return empty_; }  ///< nothing is there to be drawn

 private:
  float opacity(Now now) const;
  TimelineUse build_once(const View& view, Controls& controls);

  Gui gui_;
  Now awake_{}, said_at_{};
  std::string said_;
  bool help_scrolls_ = false;
  int help_lines_down_ = 0;  ///< to be scrolled by with the next build
  bool busy_ = false;        ///< the cursor is on the bar
  bool empty_ = true;
  // Of a bar that is there, or would be if the mouse moved.
  float bar_top_ = 1e9f;
  std::optional<TrackArea> track_;
};

}  // namespace pointreel
