#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>

#include <glm/glm.hpp>

#include "client/options/play_options.h"
#include "client/playback/stage.h"
#include "client/session/presenter.h"
#include "client/ui/controls.h"
#include "client/ui/play_statistics.h"
#include "client/window/motion.h"
#include "pointreel/error.h"

namespace pointreel {

/// The picture of a stage in a window, which is drawn whenever it would change. Needs the OpenGL
/// context that was current when it was made.
class WindowPicture {
 public:
  using TimePoint = WindowMotion::TimePoint;

  /// The arguments must outlive it.
  static Result<std::unique_ptr<WindowPicture>> create(const PlayOptions& options,
                                                       Controls& controls);

  /// Shows this stage from now on; the presenter starts a new report.
  void begin(const Stage& stage);
  /// The view of it that the options ask for. A camera path is followed by the time of the frame
  /// shown.
  Camera home(const Stage& stage, glm::ivec2 size) const;

  /// Draws the stage, which was updated at `now`, unless the picture would be the last one. True if
  /// it was drawn; its new frames are then added to `recent`.
  Result<bool> draw(Stage& stage, const Stage::Update& update, glm::ivec2 size, TimePoint now,
                    RecentFrames& recent);
  /// When to draw it again, with more pixels, unless something happens before.
  std::optional<TimePoint> next_draw(TimePoint now) const;

  Presenter& presenter() { return *presenter_; }
  const Presenter& presenter() const { return *presenter_; }
  Painter& painter() { return presenter_->painter(); }
  WindowMotion& motion() { return motion_; }

 private:
  WindowPicture(const PlayOptions& options, Controls& controls)
      : options_(options), controls_(controls) {}

  DrawOptions draw_options(const Stage& stage) const;

  const PlayOptions& options_;
  Controls& controls_;
  std::unique_ptr<Presenter> presenter_;
  RendererChoice renderer_ = RendererChoice::automatic;  ///< of the presenter
  WindowMotion motion_;
  std::size_t view_version_ = 0;      ///< of the stage when the camera looked at all of it
  DrawMode mode_ = DrawMode::surfel;  ///< for which the frames shown were prepared
};

}  // namespace pointreel
