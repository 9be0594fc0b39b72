#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "client/playback/live_playback.h"
#include "client/playback/playback.h"
#include "client/playback/reel_playback.h"
#include "client/source/source.h"
#include "pointreel/error.h"

namespace pointreel {

/// Whether `where` is the address of a live stream: ws:// or wss://, or http(s):// with /live/ in
/// its path.
bool is_live_address(const std::string& where);

/// The reels and live streams that are played together in one scene, each at its place. The time of
/// reels can be controlled, that of live streams cannot.
class Stage {
 public:
  struct Options {
    SourceOptions source;
    PrepareOptions prepare;      ///< for all sources; used instead of that in `reel` and `live`
    ReelPlayback::Options reel;  ///< `remote` is set by the address of each
    LivePlayback::Options live;
    glm::ivec2 size{1280, 720};       ///< of the picture
    Playback::OnReady on_ready = {};  ///< called for any source
  };
  struct Placed {
    std::string where;  ///< as for open_source, or a live stream's address (is_live_address)
    glm::dvec3 place{0.0};
    /// If there are any, they are played as one reel, and `where` is only its name for the user.
    std::vector<std::filesystem::path> files = {};
    std::string token = {};  ///< in place of Options::source.token, if there is one
  };
  /// Called by any thread for each frame that cannot be shown; `source` is the source's index.
  using OnError = std::function<void(std::size_t source, std::uint32_t frame, const Error&)>;

  /// The camera to begin with, for a scene with these bounds and this axis up.
  using CameraFor = std::function<Camera(const Box& bounds, Up up)>;

  /// Opens all sources; there must be at least one. Live streams connect in the background.
  static Result<std::unique_ptr<Stage>> open(const std::vector<Placed>& sources,
                                             const Options& options, const CameraFor& camera_for,
                                             OnError on_error);

  std::size_t size() const { return parts_.size(); }
  /// For people: without secrets.
  const std::string& where(std::size_t i) const { return parts_[i].where; }
  const glm::dvec3& place(std::size_t i) const { return parts_[i].place; }
  const Playback& playback(std::size_t i) const { return parts_[i].playback(); }
  // Null if the source is of the other kind.
  ReelPlayback* reel(std::size_t i) const { return parts_[i].reel(); }
  LivePlayback* live(std::size_t i) const { return parts_[i].live(); }
  /// The bounds of all sources, in the world; empty while nothing is known.
  Box bounds() const;
  /// What a camera that sees everything should look at: the bounds, but without what only a few
  /// points of a source's first frame add to them if that is much, and of a source whose first
  /// frame is a speck in them, that frame. A single point far away can make the bounds so large.
  Box view_bounds() const;
  /// Changes when the bounds of a source become known, when its first frame came, and when one came
  /// in so much more detail that it tells better where its points are. A camera that nobody moved
  /// should then look at view_bounds() again, but not whenever bounds grow.
  std::size_t view_version() const;
  /// The names of all sources' scalar fields, as far as they are known, without repetition.
  std::vector<std::string> scalar_names() const;
  Up up() const { return parts_.front().playback().up(); }
  bool playing() const;
  /// The shortest time between two frames of any source.
  double frame_seconds() const;

  void look(const Camera& camera, glm::ivec2 size);
  /// Playback::set_prepare_options of all sources.
  void set_prepare_options(const PrepareOptions& options);
  const PrepareOptions& prepare_options() const { return prepare_; }
  /// Neither OnError nor on_ready is called any more. Waits for a call that is under way.
  void silence();
  /// Calls `control` with each reel.
  template <class Control>
  void for_each_reel(const Control& control) {
    for (const Part& part : parts_) {
      if (ReelPlayback* reel = part.reel()) control(*reel);
    }
  }

  /// Makes live streams go on, or stand still.
  void set_live_playing(bool playing);

  struct Change {
    std::size_t source = 0;
    bool refined = false;
  };
  struct Update {
    std::vector<Change> changes;               ///< sources whose frame in the scene has changed
    bool ended = false;                        ///< no source will have another frame
    std::optional<Clock::TimePoint> due = {};  ///< the earliest of all sources
  };
  Update update(Clock::TimePoint now);
  /// Why a source's server has refused this viewer; none if none has.
  std::optional<Error> refusal() const;
  /// Puts a frame into the scene, whatever time it is.
  std::vector<Change> take(std::size_t source, std::shared_ptr<const SceneFrame> frame);
  const Scene& scene() const { return scene_; }

 private:
  /// Puts a frame into the scene.
  void show(std::size_t source, std::shared_ptr<const SceneFrame> frame);

  struct Part {
    std::string where;
    glm::dvec3 place;
    std::optional<int> first_level;  ///< of the frame that was shown first
    FrameBoxes first;                ///< of that frame
    std::variant<std::unique_ptr<ReelPlayback>, std::unique_ptr<LivePlayback>> source;

    Box view_bounds() const;
    Playback& playback() const {
      return std::visit([](const auto& either) -> Playback& { return *either; }, source);
    }
    ReelPlayback* reel() const {
      const auto* held = std::get_if<std::unique_ptr<ReelPlayback>>(&source);
      return held ? held->get() : nullptr;
    }
    LivePlayback* live() const {
      const auto* held = std::get_if<std::unique_ptr<LivePlayback>>(&source);
      return held ? held->get() : nullptr;
    }
  };

  /// The functions that are called, until silence().
  struct Listener;

  std::shared_ptr<Listener> listener_;
  PrepareOptions prepare_;
  std::vector<Part> parts_;
  Scene scene_;
  std::size_t first_boxes_ = 0;  ///< how often a Part::first was set
};

/// The sources of what was dropped on a window together: PLY and Draco files are one reel, in
/// natural order, and everything else is a source of its own.
std::vector<Stage::Placed> sources_of(const std::vector<std::string>& paths);

}  // namespace pointreel
