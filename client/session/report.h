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
#include "client/source/live_source.h"
#include "client/source/source.h"

namespace pointreel {

/// What the package has of a frame that is shown and that was not fetched, because the view or the
/// mode does not need it.
struct NotFetched {
  std::uint32_t layers = 0;
  bool colors = false, normals = false;
  std::uint64_t bytes = 0;
};

/// For a frame of which these layers were chosen; nothing for a file.
NotFetched not_fetched(const Manifest& manifest, const SceneFrame& frame, const LayerRange& layers);

/// What playing one source came to.
struct SourceReport {
  std::string where;
  glm::dvec3 place{0.0};
  std::uint64_t frames_shown = 0, frames_dropped = 0, errors = 0;
  std::optional<ReelPlayback::Statistics> reel;  ///< of a reel, as are the choices
  std::vector<ReelPlayback::Chosen> chosen;
  std::optional<LiveCounts> live;  ///< of a live stream
  TimeSamples delay;               ///< of a live stream: from capture to the end of drawing
};

/// What a window came to, and what it showed at the end.
struct WindowReport {
  // Since the process began.
  double window_ms = 0.0;         ///< until there was one
  double first_picture_ms = 0.0;  ///< until there was a frame in it; 0: never
  TimeSamples interface;          ///< of each picture with any: to make and draw it
  /// While the time is dragged: from each move that asks for another frame, or the first one that
  /// is not answered, until the window shows the frame that is asked for by then.
  TimeSamples scrub_to_picture;
  bool playing = false, loop = false, help = false, drawing = false, statistics = false;
  bool floor = false, flying = false;
  double position_s = 0.0, speed = 1.0;
  std::uint32_t frame = 0;
  std::optional<LoopRange> loop_range;
  Camera camera;
  std::string error;  ///< shown at the end
};

/// What playing came to. Times are over the frames shown, one sample a frame; the counts of layers,
/// points, nodes, leaves, depth, drawn and what was not drawn are those of the last frame shown.
class PlayReport {
 public:
  std::vector<SourceReport> sources;
  std::optional<WindowReport> window;  ///< if there was one
  std::string gl_renderer;
  DrawMode mode = DrawMode::surfel;
  Instancing instancing = Instancing::pull;
  Splatting splatting = Splatting::normalized;
  double delta = 0.0;
  int finest_level = 0;  ///< of the package's octrees; 0 where there are none
  glm::ivec2 size{0};    ///< of the picture in pixels
  double seconds =
      0.0;  ///< in a window from the first picture on; offscreen from the first fetch on
  std::uint64_t frames_dropped =
      0;                     ///< their time came and went without them, broken ones included
  std::uint64_t errors = 0;  ///< frames that could not be fetched or decoded

  /// A frame was drawn for the first time.
  void add(const SceneFrame& frame, const NotFetched& rest, const DrawStats& drawn);
  /// The frame shown was drawn for the first time as it is now, with more levels than before.
  void add_refined(const SceneFrame& frame, const NotFetched& rest, const DrawStats& drawn);

  std::uint64_t frames_shown() const { return frames_shown_; }
  /// By all sources, frames that were never shown included.
  std::uint64_t fetched_bytes() const;
  std::string to_json() const;

 private:
  void set_last(const SceneFrame& frame, const NotFetched& rest, const DrawStats& drawn);

  std::uint64_t frames_shown_ = 0, frames_refined_ = 0, frames_reduced_ = 0;
  std::uint64_t shown_rest_ = 0;  ///< bytes that were not fetched of frames before the last
  TimeSamples fetch_, decode_, normals_, svo_, cut_, render_;
  std::uint64_t points_ = 0, nodes_ = 0, leaves_ = 0;
  std::uint32_t layers_ = 0;
  int depth_ = 0;
  NotFetched rest_;
  DrawStats last_;
};

}  // namespace pointreel
