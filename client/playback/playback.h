#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/playback/clock.h"
#include "client/prepare/prepare.h"
#include "client/scene/camera.h"
#include "client/scene/frame.h"
#include "pointreel/geometry.h"
#include "pointreel/package.h"

namespace pointreel {

/// Something that gives frames as time goes on: a reel or a live stream. It knows nothing of OpenGL
/// or windows. One thread makes all calls, the one that draws.
class Playback {
 public:
  struct Update {
    std::shared_ptr<const SceneFrame> frame;  ///< to be shown now; null: none is there yet
    bool refined = false;                     ///< it was given before, with less detail
    bool ended = false;                       ///< no more frames will come
    /// When to call update() again even if OnReady is not called, because the next frame begins or
    /// what to fetch is to be reconsidered. None: not before OnReady is called.
    std::optional<Clock::TimePoint> due = {};
  };
  /// Called by any thread when there may be something new: a frame or a thumbnail is ready or
  /// failed, or bounds() or trouble() have changed. It must be quick, and must not call the
  /// playback.
  using OnReady = std::function<void()>;

  virtual ~Playback() = default;

  virtual const std::string& name() const = 0;
  virtual Up up() const = 0;
  /// The nominal time between two frames at the current speed, > 0.
  virtual double frame_seconds() const = 0;
  /// The bounds of all frames, as far as they are known; empty while nothing is known.
  virtual Box bounds() const = 0;
  /// The scalar fields of all frames, as far as they are known.
  virtual std::vector<ScalarRange> scalars() const = 0;

  /// Sets the camera and the size of the picture: no more detail than they show is fetched. Cheap
  /// if nothing changes.
  virtual void look(const Camera& camera, glm::ivec2 size) = 0;
  /// How frames are prepared from now on. Those of a reel that are ready are made again if they
  /// would differ; another pixel_size counts from the next look() on. Cheap if nothing changes.
  virtual void set_prepare_options(const PrepareOptions& options) = 0;
  virtual Update update(Clock::TimePoint now) = 0;

  /// While nothing comes: what is wrong, and where, in one line.
  virtual std::optional<std::string> trouble() const = 0;
  /// How many frames were not shown because they were late.
  virtual std::uint64_t dropped() const = 0;
  /// How many frames could not be fetched or prepared.
  virtual std::uint64_t errors() const = 0;
};

}  // namespace pointreel
