#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "client/playback/clock.h"
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
  };

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
  virtual void set_mode(DrawMode mode) = 0;
  /// PrepareOptions::delta, of frames from now on; a reel's that are there are made again.
  virtual void set_delta(double delta) = 0;
  /// Whether normals are to be seen, in modes that do without them too; as set_delta.
  virtual void set_show_normals(bool show) = 0;
  /// DrawOptions::pixel_size, from the next look() on.
  virtual void set_pixel_size(float pixel_size) = 0;
  virtual Update update(Clock::TimePoint now) = 0;

  /// What is wrong while nothing comes, and where, in one line.
  virtual std::optional<std::string> trouble() const = 0;
  /// Frames whose time came and went without them.
  virtual std::uint64_t dropped() const = 0;
  /// Frames that could not be fetched or prepared.
  virtual std::uint64_t errors() const = 0;
};

}  // namespace pointreel
