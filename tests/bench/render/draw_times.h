#pragma once

#include <memory>
#include <span>
#include <vector>

#include <nlohmann/json.hpp>

#include "client/render/opengl/gl_renderer.h"
#include "tests/bench/measure.h"

namespace pointreel::bench {

/// A picture whose drawing is timed.
struct TimedDraw {
  std::shared_ptr<const SceneFrame> frame;
  DrawOptions options;
};

/// How drawing is timed.
enum class Stopwatch {
  gpu,   ///< by a timer query: the work of a graphics card
  wall,  ///< until the picture is complete: for software OpenGL, whose queries are unreliable
};

/// The milliseconds of each draw if its instances are already uploaded. Each run gives the mean
/// over the cameras, as in Slomp et al., Geometry Instancing, section VII. The first run is not
/// counted. The draws take turns, so that other load on the machine affects them equally.
Result<std::vector<Timing>> time_in_turns(Renderer& renderer, std::span<const TimedDraw> draws,
                                          std::span<const Camera> cameras, glm::ivec2 size,
                                          int runs, Stopwatch stopwatch);

/// Times a traversal of the cloud's octree with this depth, on one thread, with the whole cloud in
/// view.
Timing time_traversal(const PointCloud& cloud, int depth, glm::ivec2 size, int runs);

}  // namespace pointreel::bench
