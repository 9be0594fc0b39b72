#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "client/options/play_options.h"
#include "client/playback/stage.h"
#include "client/render/draft.h"
#include "client/scene/camera.h"
#include "client/session/painter.h"
#include "client/session/report.h"
#include "pointreel/error.h"

namespace pointreel {

/// How to draw a picture, and how long there is for it.
struct Shot {
  Camera camera;
  glm::ivec2 size{0};
  DrawOptions draw;
  Haste haste = {};
};

/// Draws what is on a stage and keeps the report of it. Needs the renderer's OpenGL context, if it
/// has one.
class Presenter {
 public:
  /// The options must outlive the presenter.
  Presenter(const PlayOptions& options, std::unique_ptr<Renderer> renderer);

  /// Draws with another renderer from now on.
  void set_renderer(std::unique_ptr<Renderer> renderer);

  /// Starts a new report, of this stage.
  void begin(const Stage& stage);

  /// Draws the scene, of which `changes` are new; they may be empty. The picture is
  /// drawn coarser than asked if there is no time for all of it (Draft).
  Result<void> draw(const Stage& stage, const std::vector<Stage::Change>& changes,
                    const Shot& shot);
  /// Counts pictures of `changes` as shown, which whoever calls has kept and are not drawn again.
  void repeat(const Stage& stage, const std::vector<Stage::Change>& changes) {
    for (const Stage::Change& change : changes) add_to_report(stage, change);
  }
  /// Whether the last picture was drawn for this shot, however coarse.
  bool shows(const Shot& shot) const;
  /// Whether the last picture was drawn coarser, or with fewer surfels, than it would be without
  /// haste.
  bool hasty() const { return hasty_; }
  const DrawStats& drawn() const { return drawn_; }  ///< of the last picture
  bool shown() const { return shown_; }              ///< any frame, since begin()

  Painter& painter() { return painter_; }
  const Painter& painter() const { return painter_; }

  /// Time since the first frame was shown; 0 before that.
  double seconds() const;
  /// Lets this time run from now on, even if no frame has been shown yet.
  void start_clock();
  /// Brings the counts of the report up to date. If every frame is drawn, however long it takes,
  /// `lost` are those that could not be; otherwise the stage has counted them.
  void count(const Stage& stage, std::optional<std::uint64_t> lost = std::nullopt);
  /// Adds what the window showed at the end. `mode` is the one that the user has chosen last.
  void set_window(const WindowReport& window, DrawMode mode) {
    report_.window = window;
    report_.mode = mode;
  }
  /// Writes the report to the file that the options name, if any.
  Result<void> write_report() const;

 private:
  void add_to_report(const Stage& stage, const Stage::Change& change);

  const PlayOptions& options_;
  Painter painter_;
  Draft draft_;
  PlayReport report_;
  std::optional<Shot> shot_;  ///< of the last picture
  DrawStats drawn_;
  bool shown_ = false, hasty_ = false;
  std::optional<std::chrono::steady_clock::time_point> started_;
};

}  // namespace pointreel
