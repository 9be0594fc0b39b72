#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "client/playback/clock.h"
#include "client/prepare/prepare.h"
#include "client/scene/camera.h"
#include "client/scene/frame.h"
#include "pointreel/geometry.h"

namespace pointreel {

/// Something that gives frames as time goes on: a reel or a live stream. Knows nothing of OpenGL or
/// windows. All calls are made by one thread, the one that draws.
class Playback {
 public:
  struct Update {
    std::shared_ptr<const SceneFrame> frame;  ///< to be shown now; null: none is there yet
    /// `frame` is the one given before, with more levels.
    bool refined = false;
    bool ended = false;  ///< nothing will come any more
    /// When to call update() again, even if nobody is told to (OnReady): when the next frame
    /// begins. None: not before.
    std::optional<Clock::TimePoint> due = {};
  };
  /// Called by any thread when update(), or anything else that is asked for, may have something
  /// new: a frame or a thumbnail is ready or cannot be had, or bounds or trouble() have changed. It
  /// must be quick, and must call nothing of what calls it.
  using OnReady = std::function<void()>;

  virtual ~Playback() = default;

  virtual const std::string& name() const = 0;
  virtual char up() const = 0;  ///< the axis that points up, 'y' or 'z'
  /// Between two frames, at the speed of now; nominal, > 0.
  virtual double frame_seconds() const = 0;
  /// Of all that will be shown, as far as is known; empty while nothing is.
  virtual Box bounds() const = 0;

  /// The camera and the size of the picture: nothing finer than they show needs to be there. Cheap
  /// while nothing changes.
  virtual void look(const Camera& camera, glm::ivec2 size) = 0;
  /// How frames are prepared from now on. Those of a reel that are ready are made again if they
  /// would differ; another pixel_size counts from the next look() on. Cheap if nothing changes.
  virtual void set_prepare_options(const PrepareOptions& options) = 0;
  virtual Update update(Clock::TimePoint now) = 0;

  /// What is wrong while nothing comes, and where, in one line.
  virtual std::optional<std::string> trouble() const = 0;
  /// Frames whose time came and went without them.
  virtual std::uint64_t dropped() const = 0;
  /// Frames that could not be fetched or prepared.
  virtual std::uint64_t errors() const = 0;
};

}  // namespace pointreel
