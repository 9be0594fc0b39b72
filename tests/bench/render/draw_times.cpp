#include "tests/bench/render/draw_times.h"

#include <cstdint>

#include <epoxy/gl.h>

#include "client/scene/cut.h"
#include "codec/core/build.h"
#include "common/base/try.h"
#include "pointreel/octree.h"

namespace pointreel::bench {
namespace {

class TimerQuery {
 public:
  TimerQuery() { glGenQueries(1, &name_); }
  ~TimerQuery() { glDeleteQueries(1, &name_); }
  TimerQuery(const TimerQuery&) = delete;
  TimerQuery& operator=(const TimerQuery&) = delete;

  void begin() const { glBeginQuery(GL_TIME_ELAPSED, name_); }
  void end() const { glEndQuery(GL_TIME_ELAPSED); }
  /// Waits for the result.
  double milliseconds() const {
    GLuint64 nanoseconds = 0;
    glGetQueryObjectui64v(name_, GL_QUERY_RESULT, &nanoseconds);
    return 1e-6 * static_cast<double>(nanoseconds);
  }

 private:
  GLuint name_ = 0;
};

}  // namespace

Result<std::vector<Timing>> time_in_turns(Renderer& renderer, std::span<const TimedDraw> draws,
                                          std::span<const Camera> cameras, glm::ivec2 size,
                                          int runs, Stopwatch stopwatch) {
  const TimerQuery query;
  std::vector<std::vector<double>> milliseconds(draws.size());
  for (int run = -1; run < runs; ++run) {
    std::vector<double> sums(draws.size(), 0.0);
    for (const Camera& camera : cameras) {
      const TimedDraw* last = nullptr;
      for (std::size_t i = 0; i < draws.size(); ++i) {
        const TimedDraw& draw = draws[i];
        // Another frame, mode or camera is uploaded first.
        if (last == nullptr || last->frame != draw.frame ||
            last->options.mode != draw.options.mode) {
          TRY(renderer.draw(draw.frame, camera, size, draw.options));
        }
        last = &draw;
        if (stopwatch == Stopwatch::gpu) query.begin();
        const DrawStats stats = TRY(renderer.draw(draw.frame, camera, size, draw.options));
        if (stopwatch == Stopwatch::gpu) query.end();
        sums[i] += stopwatch == Stopwatch::gpu ? query.milliseconds() : stats.render_ms;
      }
    }
    for (std::size_t i = 0; run >= 0 && i < draws.size(); ++i) {
      milliseconds[i].push_back(sums[i] / static_cast<double>(cameras.size()));
    }
  }
  std::vector<Timing> timings;
  for (auto& of_draw : milliseconds) timings.push_back(summarise(std::move(of_draw)));
  return timings;
}

Timing time_traversal(const PointCloud& cloud, int depth, glm::ivec2 size, int runs) {
  const Box box = bounds(cloud);
  const auto sorted = sort_to_depth(cloud, bounding_cube(box), DepthRule::fixed(depth));
  const Svo svo = build_svo(sorted->sorted, sorted->depth);
  Camera camera;
  camera.frame_bounds(box, static_cast<double>(size.x) / size.y);
  VoxelCut cut;
  return measure(runs, [&] { cut.run(svo, camera, size, 1.0f); });
}

}  // namespace pointreel::bench
