#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/playback/reel_playback.h"
#include "client/playback/statistics.h"
#include "client/scene/camera.h"
#include "client/scene/draw_options.h"
#include "client/scene/draw_stats.h"
#include "client/scene/frame.h"
#include "client/sound/audio_player.h"
#include "client/source/live_source.h"
#include "client/source/source.h"

namespace pointreel {

/// The part of a frame that its package has but that was not fetched, because the view and the mode
/// do not need it.
struct NotFetched {
  std::uint32_t layers = 0;
  bool colors = false, normals = false;
  std::uint64_t bytes = 0;
};

/// For a frame of which these layers were chosen; nothing for a file.
NotFetched not_fetched(const Manifest& manifest, const SceneFrame& frame, const LayerRange& layers);

/// How playing one source went.
struct SourceReport {
  std::string where;
  glm::dvec3 place{0.0};
  std::uint64_t frames_shown = 0, frames_dropped = 0, errors = 0;
  std::optional<ReelPlayback::Statistics> reel;  ///< reels only
  std::vector<LayerPlan::Chosen> chosen;         ///< reels only
  std::optional<LiveCounts> live;                ///< live streams only
  TimeSamples delay;  ///< live streams only: from capture to the end of drawing, in ms
};

/// How playing in a window went, and what the window showed at the end.
struct WindowReport {
  double window_ms = 0.0;  ///< from the start of the process until the window was there
  /// From the start of the process until the window showed a frame; 0: it never did.
  double first_picture_ms = 0.0;
  TimeSamples interface;  ///< to build and draw the interface, for each picture that has any
  /// While the time is dragged: from the first move that asks for another frame until the window
  /// shows the frame that is asked for by then.
  TimeSamples scrub_to_picture;
  bool playing = false, loop = false, help = false, drawing = false, statistics = false;
  bool floor = false, flying = false;
  double position_s = 0.0, speed = 1.0;
  std::uint32_t frame = 0;
  std::optional<LoopRange> loop_range;
  Camera camera;
  std::optional<AudioPlayer::Statistics> audio;  ///< none if nothing has sound
  double first_sound_ms = 0.0;  ///< from the start of the process until it was heard; 0: never
  std::string error;            ///< that the window showed at the end; empty: none
};

/// How playing went. There is one sample of each time for every frame shown. The numbers of layers,
/// points, nodes, leaves and elements, drawn or not, and the depth are those of the last frame
/// shown.
class PlayReport {
 public:
  std::vector<SourceReport> sources;
  std::optional<WindowReport> window;  ///< none offscreen
  std::string renderer;
  DrawMode mode = DrawMode::surfel;
  Instancing instancing = Instancing::pull;
  Splatting splatting = Splatting::normalized;
  double delta = 0.0;
  int finest_level = 0;  ///< of the packages' octrees; 0 if there are none
  glm::ivec2 size{0};    ///< of the picture in pixels
  double seconds =
      0.0;  ///< in a window from the first picture on, offscreen from the first fetch on
  std::uint64_t frames_dropped = 0;  ///< that were not shown at their time, broken ones included
  std::uint64_t errors = 0;          ///< frames that could not be fetched or decoded

  /// Counts a frame that was drawn for the first time.
  void add(const SceneFrame& frame, const NotFetched& rest, const DrawStats& drawn);
  /// Counts a frame that was drawn again because more of its levels have come.
  void add_refined(const SceneFrame& frame, const NotFetched& rest, const DrawStats& drawn);

  std::uint64_t frames_shown() const { return frames_shown_; }
  /// The bytes that all sources fetched, also for frames that were never shown.
  std::uint64_t fetched_bytes() const;
  std::string to_json() const;

 private:
  void set_last(const SceneFrame& frame, const NotFetched& rest, const DrawStats& drawn);

  std::uint64_t frames_shown_ = 0, frames_refined_ = 0, frames_reduced_ = 0;
  std::uint64_t shown_rest_ = 0;  ///< bytes not fetched of all frames before the last
  TimeSamples fetch_, decode_, normals_, svo_, cut_, render_;
  std::uint64_t points_ = 0, nodes_ = 0, leaves_ = 0;
  std::uint32_t layers_ = 0;
  int depth_ = 0;
  NotFetched rest_;
  DrawStats last_;
};

}  // namespace pointreel
