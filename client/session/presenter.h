#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
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

// What playing in a window and without one have in common.

Stage::Options stage_options(const PlayOptions& options);

/// Looks at all of the bounds, from where the options say; a camera's path is then at `time_us`.
Camera camera_at(const PlayOptions& options, std::uint64_t time_us, const Box& bounds, char up,
                 glm::ivec2 size);
/// Where playback begins.
Camera first_camera(const PlayOptions& options, const Box& bounds, char up, glm::ivec2 size);
std::uint64_t start_us(const PlayOptions& options);

/// Of everything that the stage shows; none while it knows no bounds.
std::optional<FloorGrid> floor_under(const Stage& stage, const Camera& camera);

/// Only one frame is to be shown, of one source.
bool single_frame(const PlayOptions& options);

/// Draws what a stage shows, and keeps the report of it. Needs the OpenGL context that was current
/// when it was made.
class Presenter {
 public:
  static Result<std::unique_ptr<Presenter>> create(const PlayOptions& options);

  /// The report is of this stage from now on.
  void begin(const Stage& stage);

  /// Draws the scene with what has changed in it; smaller than it is shown, if that is what there
  /// is time for (Draft).
  Result<void> show(const Stage& stage, const std::vector<Stage::Change>& changes,
                    const Camera& camera, glm::ivec2 size, const DrawOptions& draw,
                    const Haste& haste);
  /// Draws it once more, for another camera, size or way to draw.
  Result<void> show_again(const Stage& stage, const Camera& camera, glm::ivec2 size,
                          const DrawOptions& draw, const Haste& haste);
  const DrawStats& drawn() const { return drawn_; }  ///< by the last of these
  bool shown() const { return shown_; }              ///< anything at all, since begin()

  Painter& painter() { return *painter_; }

  /// Since the first picture; 0 before.
  double seconds() const;
  /// Time counts from now on even if nothing is shown yet.
  void start_clock();
  /// Brings the counts of the report up to date. `lost`: frames of every one that were skipped;
  /// with `every_frame` nothing else is ever late.
  const PlayReport& report(const Stage& stage, std::uint64_t lost, bool every_frame);
  /// What the window showed at the end; `mode` is what the user has chosen last.
  void set_window(const WindowReport& window, DrawMode mode) {
    report_.window = window;
    report_.mode = mode;
  }
  /// Where options.json says, if it does.
  Result<void> write_report() const;

 private:
  explicit Presenter(const PlayOptions& options) : options_(options) {}

  /// Notes how it is drawn, and draws it.
  Result<DrawStats> paint(const Stage& stage, const Camera& camera, glm::ivec2 size,
                          const DrawOptions& draw, const Haste& haste);

  const PlayOptions& options_;
  std::unique_ptr<Painter> painter_;
  Draft draft_;
  PlayReport report_;
  DrawStats drawn_;
  bool shown_ = false;
  std::optional<std::chrono::steady_clock::time_point> started_;
};

}  // namespace pointreel
