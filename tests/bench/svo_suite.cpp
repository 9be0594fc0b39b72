#include <cmath>

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "client/scene/cut.h"
#include "codec/core/build.h"
#include "common/process/print.h"
#include "common/threads/tbb_executor.h"
#include "datasets_synthetic/sequences.h"
#include "pointreel/octree.h"
#include "tests/bench/clouds.h"
#include "tests/bench/measure.h"
#include "tests/bench/suites.h"
#include "tests/reference/recursive_octree.h"

namespace pointreel::bench {
namespace {

constexpr double kDelta = 0.05;

/// Quantises, sorts, chooses the depth and builds, as the client does for a frame of points.
Svo build(const PointCloud& cloud, const Cube& cube, const Executor& executor = {}) {
  const auto points = sort_to_depth(cloud, cube, DepthRule::by_delta(kDelta), executor);
  return build_svo(points->sorted, points->depth, executor);
}

struct Row {
  std::size_t points = 0;
  Timing fast, attributes, reference;
  Svo svo;
};

Row measure_size(std::size_t n, int runs) {
  const PointCloud cloud = scan_like_cloud(n);
  const Cube cube = bounding_cube(bounds(cloud));
  Row row;
  row.points = n;
  row.svo = build(cloud, cube);
  row.fast = measure(runs, [&] { build(cloud, cube); });
  const SortedPoints sorted = sort_points(cloud, cube);
  row.attributes = measure(runs, [&] { mean_attributes(row.svo, cloud, sorted); });
  row.reference = measure(std::max(3, runs / 5),
                          [&] { reference::RecursiveOctree(cloud, cube, kDelta, kMaxDepth); });
  return row;
}

/// "Traverse" in Slomp et al., Geometry Instancing, Table III: the cut of a whole figure, in a
/// picture as large as the paper's, of a tree as deep as the paper's for a delta of 10 %.
nlohmann::json measure_traversal(int runs, std::vector<Bar>& bars) {
  constexpr glm::ivec2 kPicture(1920, 1280);
  constexpr int kDepth = 10, kPoses = 3;
  const Motion& motion = *find_motion("baseball");
  std::vector<double> milliseconds;
  std::size_t leaves = 0, emitted = 0;
  VoxelCut cut;
  for (int pose = 0; pose < kPoses; ++pose) {
    const auto cloud = sequence_frame(motion, {}, pose * motion.poses / kPoses);
    if (!cloud) return {{"error", cloud.error().message}};
    const Svo svo = build_svo(sort_points(*cloud, bounding_cube(bounds(*cloud)), kDepth), kDepth);
    Camera camera;
    camera.frame_bounds(bounds(*cloud), static_cast<double>(kPicture.x) / kPicture.y);
    const auto times = time_runs(runs, [&] { cut.run(svo, camera, kPicture, 1.0f); });
    milliseconds.insert(milliseconds.end(), times.begin(), times.end());
    leaves += svo.leaf_count();
    emitted += cut.nodes().size();
  }
  const Timing timing = summarise(milliseconds);
  print(
      "traversal of baseball, depth {}, {}x{}, one thread: {:.2f} ms ({:.2f} to {:.2f}), {} of "
      "{} leaves emitted\n",
      kDepth, kPicture.x, kPicture.y, timing.median, timing.min, timing.max, emitted / kPoses,
      leaves / kPoses);
  bars.push_back({"traversal of baseball at depth 10, full view", timing.median, "ms", 1.0});
  return {{"sequence", "baseball"},
          {"depth", kDepth},
          {"picture", {kPicture.x, kPicture.y}},
          {"leaves", leaves / kPoses},
          {"emitted", emitted / kPoses},
          {"traverse_ms", to_json(timing)}};
}

/// The same work on one thread and on two.
struct OnThreads {
  double one = 0.0, two = 0.0;  ///< ms, the least of all runs: other programs may use the cores
  double gain() const { return one / two; }
};

/// Runs alternate, so that both meet the same load by other programs.
template <class Work>
OnThreads measure_on_threads(int runs, const Work& work) {
  tbb::task_arena arena(2);
  std::vector<double> one, two;
  for (int i = 0; i < runs; ++i) {
    one.push_back(time_runs(1, [&] { work(Executor{}); }).front());
    arena.execute([&] { two.push_back(time_runs(1, [&] { work(tbb_executor()); }).front()); });
  }
  return {summarise(one).min, summarise(two).min};
}

nlohmann::json measure_threads(int runs, std::vector<Bar>& bars) {
  constexpr std::size_t kPoints = 1'000'000;
  const PointCloud cloud = scan_like_cloud(kPoints);
  const Cube cube = bounding_cube(bounds(cloud));
  const auto points = sort_to_depth(cloud, cube, DepthRule::by_delta(kDelta));
  const Svo svo = build_svo(points->sorted, points->depth);
  auto rows = nlohmann::json::array();
  const auto add = [&](const char* what, double least_gain, const OnThreads& times) {
    print("{:<40} {:>8.2f} ms {:>8.2f} ms {:>6.2f}x\n", what, times.one, times.two, times.gain());
    rows.push_back({{"what", what}, {"threads_1_ms", times.one}, {"threads_2_ms", times.two}});
    bars.push_back(
        {fmt::format("{}, one thread / two", what), times.gain(), "x", least_gain, true});
  };
  print("\n{:<40} {:>11} {:>11} {:>7}\n", "1,000,000 points", "one thread", "two", "gain");
  add("building an SVO", 1.7,
      measure_on_threads(runs, [&](const Executor& executor) { build(cloud, cube, executor); }));
  add("its mean attributes", 1.7, measure_on_threads(runs, [&](const Executor& executor) {
        mean_attributes(svo, cloud, points->sorted, executor);
      }));
  return rows;
}

}  // namespace

nlohmann::json run_svo(const SuiteOptions& options) {
  const int runs = options.quick ? 5 : 25;
  print("Building an SVO, delta {} %, one thread, ms: median (min to max)\n", kDelta * 100);
  print("{:>9} {:>6} {:>9} {:>9} {:>8} {:>22} {:>10} {:>22} {:>7}\n", "points", "depth", "nodes",
        "leaves", "lost", "build", "+ means", "recursive", "ratio");
  auto rows = nlohmann::json::array();
  std::vector<Bar> bars;
  double small_per_point = 0.0;
  std::vector<std::size_t> sizes = {88'315};
  if (!options.quick) sizes.insert(sizes.end(), {250'000, 500'000, 1'000'000});
  for (const std::size_t n : sizes) {
    const Row row = measure_size(n, runs);
    const double ratio = row.reference.median / row.fast.median;
    const double lost = 1.0 - static_cast<double>(row.svo.leaf_count()) / static_cast<double>(n);
    const auto cell = [](const Timing& t) {
      return fmt::format("{:.2f} ({:.2f} to {:.2f})", t.median, t.min, t.max);
    };
    print("{:>9} {:>6} {:>9} {:>9} {:>6.2f} % {:>22} {:>10.2f} {:>22} {:>6.1f}x\n", n,
          row.svo.depth, row.svo.internal_count(), row.svo.leaf_count(), 100 * lost, cell(row.fast),
          row.attributes.median, cell(row.reference), ratio);
    rows.push_back({{"points", n},
                    {"depth", row.svo.depth},
                    {"nodes", row.svo.internal_count()},
                    {"leaves", row.svo.leaf_count()},
                    {"actual_loss", lost},
                    {"build_ms", to_json(row.fast)},
                    {"mean_attributes_ms", to_json(row.attributes)},
                    {"recursive_ms", to_json(row.reference)},
                    {"ratio", ratio}});
    const double per_point = row.fast.median / static_cast<double>(n);
    if (n == sizes.front()) {
      small_per_point = per_point;
      bars.push_back({"building an SVO of 88,315 points", row.fast.median, "ms", 2.0});
      bars.push_back({"recursive build / our build, 88,315 points", ratio, "x", 10.0, true});
    } else if (n == 1'000'000) {
      bars.push_back({"time per point of 1,000,000 points / of 88,315 points",
                      per_point / small_per_point, "x", 2.0});
    }
  }
  const nlohmann::json traversal = measure_traversal(4 * runs, bars);
  const nlohmann::json threads =
      options.quick ? nlohmann::json::array() : measure_threads(runs, bars);
  print(bars, options.quick);
  return {{"delta", kDelta},
          {"rows", rows},
          {"traversal", traversal},
          {"threads", threads},
          {"bars", to_json(bars, options.quick)}};
}

}  // namespace pointreel::bench
