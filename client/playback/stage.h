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

/// Whether it names a live stream: ws:// or wss://, or http(s):// with /live/ in its path.
bool is_live_address(const std::string& where);

/// What is played together in one scene: reels and live streams, each at its place. Controls of
/// time are those of all reels; live streams have none.
class Stage {
 public:
  struct Options {
    SourceOptions source;
    PrepareOptions prepare;      ///< of all sources, instead of that in `reel` and `live`
    ReelPlayback::Options reel;  ///< `remote` is found out for each
    LivePlayback::Options live;
    glm::ivec2 size{1280, 720};       ///< of the picture
    Playback::OnReady on_ready = {};  ///< of any source
  };
  struct Placed {
    std::string where;  ///< open_source's, or a live stream's address (is_live_address)
    glm::dvec3 place{0.0};
    /// Instead of `where`, which is for people then, if there are any: a reel of these.
    std::vector<std::filesystem::path> files = {};
  };
  /// Told of each frame that cannot be shown, by any thread; `source` is its index.
  using OnError = std::function<void(std::size_t source, std::uint32_t frame, const Error&)>;

  /// How the camera looks at a scene with these bounds, and this axis up, to begin with.
  using CameraFor = std::function<Camera(const Box& bounds, char up)>;

  /// Opens all. `sources` is not empty. Live streams are connected to in the background.
  static Result<std::unique_ptr<Stage>> open(const std::vector<Placed>& sources,
                                             const Options& options, const CameraFor& camera_for,
                                             OnError on_error);

  std::size_t size() const { return parts_.size(); }
  const std::string& where(std::size_t i) const { return parts_[i].where; }
  const glm::dvec3& place(std::size_t i) const { return parts_[i].place; }
  const Playback& playback(std::size_t i) const { return parts_[i].playback(); }
  /// Null if that is a live stream.
  ReelPlayback* reel(std::size_t i) const { return parts_[i].reel(); }
  const LivePlayback* live(std::size_t i) const { return parts_[i].live(); }
  /// In the world; empty while nothing is known.
  Box bounds() const;
  /// Sources whose bounds are known.
  std::size_t bounded() const;
  char up() const { return parts_.front().playback().up(); }
  bool playing() const;
  /// Between two frames of whatever has the most of them.
  double frame_seconds() const;

  void look(const Camera& camera, glm::ivec2 size);
  /// As Playback's, for all sources.
  void set_prepare_options(const PrepareOptions& options);
  const PrepareOptions& prepare_options() const { return prepare_; }
  /// Neither OnError nor on_ready is called any more. Waits for a call that is under way.
  void silence();
  /// Of each reel.
  template <class Control>
  void for_each_reel(const Control& control) {
    for (const Part& part : parts_) {
      if (ReelPlayback* reel = part.reel()) control(*reel);
    }
  }

  /// Live streams stand still, or go on.
  void set_live_playing(bool playing);

  struct Change {
    std::size_t source = 0;
    bool refined = false;
  };
  struct Update {
    std::vector<Change> changes;  ///< sources that have another frame in the scene than before
    bool ended = false;           ///< of all sources
    std::optional<Clock::TimePoint> due = {};  ///< the first of all sources'
  };
  Update update(Clock::TimePoint now);
  /// Puts a frame into the scene without any clock.
  std::vector<Change> take(std::size_t source, std::shared_ptr<const SceneFrame> frame);
  const Scene& scene() const { return scene_; }

 private:
  struct Part {
    std::string where;
    glm::dvec3 place;
    std::variant<std::unique_ptr<ReelPlayback>, std::unique_ptr<LivePlayback>> source;

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

  /// Who is told of errors and news, for as long as somebody listens.
  struct Listener;

  std::shared_ptr<Listener> listener_;
  PrepareOptions prepare_;
  std::vector<Part> parts_;
  Scene scene_;
};

/// What was dropped on a window together, or named so: PLY and Draco files are one reel, in natural
/// order; everything else is a source of its own.
std::vector<Stage::Placed> sources_of(const std::vector<std::string>& paths);

}  // namespace pointreel
