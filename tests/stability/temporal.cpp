#include <memory>

#include <fmt/format.h>

#include "client/playback/buffer.h"
#include "client/scene/camera.h"
#include "client/scene/cut.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "tests/stability/check.h"
#include "tests/stability/clouds.h"

namespace pointreel::stability {
namespace {

void check_counts(Checks& checks) {
  const std::size_t counts[] = {1000, 10, 10000, 0, 1, 100, 10000};
  const Cube cube{glm::dvec3(-0.5), 1.0};  // all frames of a group share a cube
  Camera camera;
  camera.frame_bounds({cube.origin, cube.origin + cube.edge}, 1.0);
  VoxelCut cut;  // keeps its buffers between frames
  for (const Setting& setting : settings(9)) {
    std::size_t right = 0, stale = 0;
    for (const std::size_t count : counts) {
      const auto frame = encode_frame(ball_cloud(count), cube, setting.options);
      if (!frame) continue;
      const auto decoded = decode_frame(layer_views(frame->layers));
      if (!decoded || decoded->source_points != count) continue;
      ++right;
      if (!decoded->svo) continue;
      cut.run(*decoded->svo, camera, {100, 100}, 0.0f);
      if (cut.nodes().size() != decoded->svo->leaf_count()) ++stale;
      for (const CutNode& node : cut.nodes()) stale += node.node >= decoded->svo->node_count();
    }
    checks.push_back({"temporal", "point count changes by 10x", "no stale index",
                      fmt::format("{}: {} of {} frames right, {} stale nodes", setting.name, right,
                                  std::size(counts), stale),
                      right == std::size(counts) && stale == 0});
  }
}

/// Checks which frames are shown if frame 1 is missing, frame 2 is late and frame 3 is ready.
void check_missing(Checks& checks) {
  FrameBuffer::Options options;
  options.frame_count = 5;
  options.ahead = 4;
  options.loop = false;
  options.mode = DrawMode::point;
  FrameBuffer buffer(options);
  const auto answer = [&buffer](std::uint32_t frame, bool found) {
    const auto job = buffer.next_fetch();
    if (!job || job->frame != frame) return false;
    if (!found) {
      buffer.fetch_failed(*job);
      return true;
    }
    buffer.fetched(*job, {}, 0.0);
    const auto request = buffer.next_wanted();
    if (!request || request->frame != frame) return false;
    auto scene = std::make_shared<SceneFrame>();
    scene->index = frame;
    buffer.deliver(*request, std::move(scene));
    return true;
  };
  const auto shown = [&buffer](std::uint32_t frame) {
    buffer.advance(frame);
    const auto best = buffer.best();
    return best ? static_cast<int>(best->index) : -1;
  };
  bool asked = answer(0, true) && answer(1, false);
  const auto job = buffer.next_fetch();
  if (job) buffer.fetched(*job, {}, 0.0);
  const auto late = buffer.next_wanted();  // frame 2, which is delivered only after its time
  asked = asked && late && late->frame == 2 && answer(3, true);
  const int at_0 = shown(0), at_1 = shown(1), at_2 = shown(2), at_3 = shown(3);
  bool passed = asked && at_0 == 0 && at_1 == 0 && at_2 == 0 && at_3 == 3;
  if (late) {
    auto scene = std::make_shared<SceneFrame>();
    scene->index = 2;
    buffer.deliver(*late, std::move(scene));
  }
  const int after = shown(3);
  passed = passed && after == 3;
  checks.push_back(
      {"temporal", "frame missing or late",
       "the last frame is held; the next one follows; a late frame is not shown afterwards",
       fmt::format("1 missing, 2 late: shown {}, {}, {}, {}, {}", at_0, at_1, at_2, at_3, after),
       passed});
}

void check_first_lost(Checks& checks) {
  const Cube cube{glm::dvec3(-0.5), 1.0};
  for (const Setting& setting : settings(8)) {
    std::size_t decoded = 0;
    for (std::size_t frame = 1; frame <= 4; ++frame) {  // frame 0 never arrives
      const auto encoded = encode_frame(ball_cloud(500 + frame), cube, setting.options);
      if (!encoded) continue;
      const auto result = decode_frame(layer_views(encoded->layers));
      decoded += result && result->source_points == 500 + frame;
    }
    checks.push_back(
        {"temporal", "first frame of a group lost", "resumes at the next independent frame",
         fmt::format("{}: all {} others decode, each alone", setting.name, decoded), decoded == 4});
  }
}

}  // namespace

Checks temporal_checks() {
  Checks checks;
  check_counts(checks);
  check_missing(checks);
  check_first_lost(checks);
  return checks;
}

}  // namespace pointreel::stability
