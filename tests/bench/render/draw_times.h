#pragma once

#include <memory>
#include <span>
#include <vector>

#include <nlohmann/json.hpp>

#include "client/render/renderer.h"
#include "tests/bench/measure.h"

namespace pointreel::bench {

/// What is drawn when it is timed.
struct TimedDraw {
  std::shared_ptr<const SceneFrame> frame;
  DrawOptions options;
};

/// How long drawing takes.
enum class Stopwatch {
  gpu,   ///< a timer query: the work of a graphics card
  wall,  ///< until glFinish returns: for software OpenGL, whose queries measure nothing
};

/// The milliseconds of each draw when its instances are uploaded already: the mean over the
/// cameras, as the paper's (002, section VII), of so many runs after one that is not counted. The
/// draws take turns, so that they share whatever else the machine does.
Result<std::vector<Timing>> time_in_turns(Renderer& renderer, std::span<const TimedDraw> draws,
                                          std::span<const Camera> cameras, glm::ivec2 size,
                                          int runs, Stopwatch stopwatch);

/// Of one traversal of the octree that the cloud has at this depth, on one thread, with the whole
/// cloud in view.
Timing time_traversal(const PointCloud& cloud, int depth, glm::ivec2 size, int runs);

}  // namespace pointreel::bench
