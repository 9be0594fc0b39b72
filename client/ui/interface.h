#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/scene/legend.h"
#include "client/ui/controls.h"
#include "client/ui/gui.h"
#include "client/ui/play_statistics.h"
#include "client/ui/timeline.h"

struct GLFWwindow;

namespace pointreel {

/// Everything that is drawn over the picture: the bar while the mouse moves, panels and help while
/// the user wants them, a few words after an action, and errors while they last.
class Interface {
 public:
  using Now = Controls::Now;

  struct View {
    Now now;
    glm::vec2 size{1.0f};  ///< of the window, in its own coordinates
    std::string waiting;   ///< what the user waits for; empty: nothing
    double waiting_seconds = 0.0;
    std::string error, hint;                 ///< as in draw_error; empty: all is well
    std::optional<TimelineView> timeline;    ///< none if nothing plays
    std::vector<StatisticsLine> statistics;  ///< only while their panel is open
    RecentFrames recent;                     ///< only while their panel is open
    std::optional<Thumbnail> thumbnail;      ///< of TimelineUse::hovered_us of the last build
    std::optional<Legend> legend;            ///< of what is shown
    std::vector<std::string> fields;         ///< scalar fields that can be shown
    std::optional<Gui::Held> held;           ///< as in Gui::begin
  };

  Interface(GLFWwindow* window, float scale) : gui_(window, scale) {}

  float scale() const { return gui_.scale(); }
  void set_scale(float scale) { gui_.set_scale(scale); }

  /// Shows the bar for a moment because the mouse has moved.
  void wake(Now now) { awake_ = now; }
  /// Shows a few words for a moment.
  void say(const std::string& text, Now now);

  /// Scrolls the help, if it is open and longer than the window, by the keys that otherwise go to
  /// another time. False if this is not such a key or there is nothing to scroll.
  bool scroll_help(Action action);

  /// Whether the interface covers the picture at this point.
  bool covers(glm::dvec2 cursor) const;
  /// The bar's track, if the cursor is on it.
  std::optional<TrackArea> track_at(glm::dvec2 cursor) const;
  /// Whether it changes by itself and so must be built again soon.
  bool changing(const View& view) const;

  /// Builds what draw() draws, and says what the user does with the bar.
  TimelineUse build(const View& view, Controls& controls);
  /// Whether what was built differs from what draw() drew last.
  bool changed() const { return gui_.changed(); }
  /// Draws into the window's framebuffer.
  void draw();
  bool empty() const { return empty_; }  ///< whether there is nothing to draw

 private:
  float opacity(Now now) const;
  TimelineUse build_once(const View& view, Controls& controls);
  void build_panels(const View& view, float error, Controls& controls);

  Gui gui_;
  Now awake_{}, said_at_{};
  std::string said_;
  bool help_scrolls_ = false;
  int help_lines_down_ = 0;  ///< lines to scroll in the next build
  bool busy_ = false;        ///< the cursor is on the bar
  bool empty_ = true;
  // The bar takes the mouse even while it is hidden: the first move shows it.
  float bar_top_ = 1e9f;
  /// What the places of the panels depend on, besides their sizes.
  struct PanelState {
    glm::vec2 window{0.0f};
    float scale = 0.0f, error = 0.0f;
    bool drawing = false, statistics = false, stacked = false;
    bool operator==(const PanelState&) const = default;
  };
  PanelState panels_;
  int placings_due_ = 0;
  std::optional<TrackArea> track_;
};

}  // namespace pointreel
