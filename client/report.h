#pragma once

#include <cstdint>
#include <string>

#include <glm/glm.hpp>

#include "client/playback/statistics.h"
#include "client/render/renderer.h"
#include "client/scene/frame.h"

namespace pointreel {

/// What playing came to. Times are over the frames shown, one sample a frame; the counts of points,
/// nodes, leaves, depth and drawn are those of the last frame shown.
class PlayReport {
 public:
  std::string source;
  std::string gl_renderer;
  DrawMode mode = DrawMode::surfel;
  double delta = 0.0;
  std::uint32_t layers = 0;  ///< that are asked for of each frame; 0 where files are played
  glm::ivec2 size{0};        ///< of the picture in pixels
  double seconds =
      0.0;  ///< in a window from the first picture on; offscreen from the first fetch on
  std::uint64_t frames_dropped =
      0;                     ///< their time came and went without them, broken ones included
  std::uint64_t errors = 0;  ///< frames that could not be fetched or decoded

  /// A frame was drawn for the first time.
  void add(const SceneFrame& frame, const DrawStats& drawn);

  std::uint64_t frames_shown() const { return frames_shown_; }
  std::string to_json() const;
  /// One line for the window's title.
  std::string to_title() const;

 private:
  std::uint64_t frames_shown_ = 0, fetched_bytes_ = 0;
  TimeSamples fetch_, decode_, normals_, svo_, cut_, render_;
  std::uint64_t points_ = 0, nodes_ = 0, leaves_ = 0, drawn_ = 0;
  int depth_ = 0;
};

/// "surfel", "voxel", "point".
const char* name(DrawMode mode);

}  // namespace pointreel
