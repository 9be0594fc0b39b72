#include <algorithm>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "client/prepare/strip_frame.h"
#include "client/render/software/software_renderer.h"
#include "client/strips/strips.h"
#include "codec/core/build.h"
#include "codec/files/cloud_file.h"
#include "common/base/try.h"
#include "common/process/print.h"
#include "common/threads/tbb_executor.h"
#include "datasets_synthetic/sequences.h"
#include "tests/bench/clouds.h"
#include "tests/bench/measure.h"
#include "tests/bench/render/scenes.h"
#include "tests/bench/strip_pictures.h"
#include "tests/bench/suites.h"

namespace pointreel::bench {
namespace {

/// A cloud whose strips are made and drawn.
struct Input {
  std::string name;
  PointCloud cloud;
  double limit = 0.0;  ///< bar on two threads, ms; 0: none
};

Result<std::vector<Input>> make_inputs(const SuiteOptions& options) {
  std::vector<Input> inputs;
  inputs.push_back({"generated, 60,000 points", scan_like_cloud(60'000), 40.0});
  inputs.push_back({"generated, 100,000 points", scan_like_cloud(100'000), 70.0});
  if (!options.quick) {
    inputs.push_back({"generated, 3,600,000 points", scan_like_cloud(3'600'000), 3000.0});
    const Motion* motion = find_motion("soccer-shoot");
    inputs.push_back({"soccer-shoot, as scanned", TRY(sequence_frame(*motion, {}, 0)), 0.0});
  }
  for (const std::filesystem::path& file : options.files)
    inputs.push_back({file.string(), TRY(read_cloud_file(file)).cloud, 0.0});
  return inputs;
}

/// The same work on one thread and on two, in turns; the least of all runs, ms.
template <class Work>
std::pair<double, double> on_one_and_two_threads(int runs, const Work& work) {
  tbb::task_arena arena(2);
  std::vector<double> one, two;
  for (int i = 0; i < runs; ++i) {
    one.push_back(time_runs(1, [&] { work(Executor{}); }).front());
    arena.execute([&] { two.push_back(time_runs(1, [&] { work(tbb_executor()); }).front()); });
  }
  return {summarise(one).min, summarise(two).min};
}

/// Positions of which the tenth that is nearest to one of them moved a little.
std::vector<glm::vec3> with_a_tenth_moved(std::span<const glm::vec3> positions,
                                          std::span<const float> radii) {
  std::vector<std::pair<float, std::size_t>> nearest;
  const glm::vec3 center = positions[positions.size() / 2];
  for (std::size_t i = 0; i < positions.size(); ++i)
    nearest.emplace_back(glm::length(positions[i] - center), i);
  const auto tenth = nearest.begin() + static_cast<std::ptrdiff_t>(positions.size() / 10);
  std::nth_element(nearest.begin(), tenth, nearest.end());
  std::vector<glm::vec3> moved(positions.begin(), positions.end());
  for (auto at = nearest.begin(); at != tenth; ++at) moved[at->second] += 0.1f * radii[at->second];
  return moved;
}

/// The least times of making strips on two threads, in turns, ms.
struct UpdateTimes {
  double all = 0.0, nothing_changed = 0.0, tenth_changed = 0.0;
};
UpdateTimes update_times(const StripSurfels& surfels, const NodeAttributes& attributes, int runs) {
  const std::vector<glm::vec3> moved = with_a_tenth_moved(surfels.positions, surfels.radii);
  StripSurfels changed = surfels;
  changed.positions = moved;
  tbb::task_arena arena(2);
  std::vector<double> all, nothing, tenth;
  arena.execute([&] {
    const Executor executor = tbb_executor();
    const auto record = update_strips(surfels, attributes, nullptr, {}, executor).record;
    const auto time = [&](const StripSurfels& now, const std::shared_ptr<const StripRecord>& from) {
      return time_runs(1, [&] { update_strips(now, attributes, from, {}, executor); }).front();
    };
    for (int i = 0; i < runs; ++i) {
      all.push_back(time(changed, nullptr));
      nothing.push_back(time(surfels, record));
      tenth.push_back(time(changed, record));
    }
  });
  return {summarise(all).min, summarise(nothing).min, summarise(tenth).min};
}

/// The least time in which a frame is drawn at 1280x720, ms.
Result<double> drawing_ms(const std::shared_ptr<const SceneFrame>& frame, DrawMode mode, int runs) {
  SoftwareRenderer renderer(tbb_executor());
  DrawOptions options;
  options.mode = mode;
  Camera camera;
  camera.frame_bounds(frame->boxes.main, 16.0 / 9.0);
  double least = 1e9;
  for (int i = 0; i < runs; ++i) {
    camera.yaw += 1e-4;
    const DrawStats stats = TRY(renderer.draw(frame, camera, {1280, 720}, options));
    least = std::min(least, stats.render_ms + stats.cut_ms);
  }
  return least;
}

Result<nlohmann::json> measure_input(const Input& input, int runs, std::vector<Bar>& bars) {
  const auto surfels = TRY(prepare_cloud(input.cloud, DrawMode::surfel, 0.72));
  auto stripped = std::make_shared<SceneFrame>(*surfels);
  make_strips(*stripped, tbb_executor());
  // The tree again, which the frame does not keep. It may be less deep.
  const PointCloud& cloud = stripped->cloud;
  const auto sorted =
      TRY(sort_to_depth(cloud, bounding_cube(bounds(cloud)), DepthRule::by_delta(0.0)));
  const Svo svo = build_svo(sorted.sorted, sorted.depth);
  const NodeAttributes attributes = mean_attributes(svo, cloud, sorted.sorted);
  std::vector<glm::vec3> positions, normals;
  std::vector<float> radii;
  const glm::vec3 offset(cloud.origin - svo.cube.origin);
  std::uint64_t last = ~std::uint64_t{0};
  for (const KeyIndex& point : sorted.sorted.points) {
    const std::uint64_t key = point.key >> 3 * (sorted.sorted.levels - sorted.depth);
    if (std::exchange(last, key) == key) continue;
    positions.push_back(offset + cloud.positions[point.index]);
    normals.push_back(cloud.normals[point.index]);
    radii.push_back(cloud.radii[point.index]);
  }
  const StripSurfels from{.svo = svo,
                          .positions = positions,
                          .normals = normals,
                          .radii = radii,
                          .lines = surfels->normals_estimated};
  const auto [one, two] = on_one_and_two_threads(
      runs, [&](const Executor& executor) { make_strips(from, attributes, {}, executor); });
  const UpdateTimes update = update_times(from, attributes, runs);
  const SurfelStrips& strips = stripped->strips;
  const auto count = static_cast<std::size_t>(
      std::count(strips.indices.begin(), strips.indices.end(), kEndOfStrip));
  const std::uint32_t triangles = strips.nodes.empty() ? 0 : strips.nodes[0].triangles;
  const double draw_strips = TRY(drawing_ms(stripped, DrawMode::strip, runs + 2)),
               draw_surfels = TRY(drawing_ms(surfels, DrawMode::surfel, runs + 2));
  const double indices = static_cast<double>(strips.indices.size()) / std::max(triangles, 1u);
  print("{:<34} {:>9} {:>8} {:>9} {:>8.2f} {:>9.1f} {:>9.1f} {:>8.1f} {:>8.1f} {:>8.1f} {:>8.1f}\n",
        input.name, cloud.size(), count, triangles, indices, one, two, update.nothing_changed,
        update.tenth_changed, draw_strips, draw_surfels);
  if (input.limit > 0.0) {
    bars.push_back({"strips of " + input.name + ", two threads", two, "ms", input.limit});
    if (cloud.size() <= 100'000)
      bars.push_back({"the same, nothing changed", update.nothing_changed, "ms", 5.0});
    bars.push_back({"the same, a tenth changed", update.tenth_changed / update.all, "of all", 0.3});
  }
  return nlohmann::json{{"input", input.name},
                        {"surfels", cloud.size()},
                        {"strips", count},
                        {"triangles", triangles},
                        {"indices_per_triangle", indices},
                        {"threads_1_ms", one},
                        {"threads_2_ms", two},
                        {"record_ms", update.all},
                        {"nothing_changed_ms", update.nothing_changed},
                        {"tenth_changed_ms", update.tenth_changed},
                        {"draw_strips_ms", draw_strips},
                        {"draw_surfels_ms", draw_surfels}};
}

}  // namespace

nlohmann::json run_strips(const SuiteOptions& options) {
  auto rows = nlohmann::json::array();
  auto pictures = nlohmann::json::array();
  std::vector<Bar> bars;
  const auto measure_all = [&]() -> Result<void> {
    if (!options.quick) pictures = TRY(measure_strip_pictures());
    print("{:<34} {:>9} {:>8} {:>9} {:>8} {:>19} {:>17} {:>17}\n", "", "", "", "", "indices",
          "making them, ms", "changed, ms", "drawing, ms");
    print("{:<34} {:>9} {:>8} {:>9} {:>8} {:>9} {:>9} {:>8} {:>8} {:>8} {:>8}\n", "input",
          "surfels", "strips", "triangles", "each", "1 thread", "2 threads", "nothing", "a tenth",
          "strips", "surfels");
    for (const Input& input : TRY(make_inputs(options))) {
      const bool slow = input.cloud.size() > 1'000'000;
      rows.push_back(TRY(measure_input(input, options.quick || slow ? 2 : 7, bars)));
    }
    return {};
  };
  const auto measured = measure_all();
  print(bars, options.quick);
  nlohmann::json report = {
      {"rows", rows}, {"pictures", pictures}, {"bars", to_json(bars, options.quick)}};
  if (!measured) report["error"] = measured.error().message;
  return report;
}

}  // namespace pointreel::bench
