#include "tests/bench/report/structure.h"

#include <algorithm>
#include <array>
#include <map>
#include <numbers>
#include <numeric>
#include <string_view>

#include "client/scene/camera.h"
#include "client/scene/cut.h"
#include "codec/core/build.h"
#include "common/base/try.h"
#include "pointreel/octree.h"
#include "tests/bench/measure.h"
#include "tests/reference/recursive_octree.h"

namespace pointreel::bench {
namespace {

constexpr std::array<double, 3> kDeltas = {0.02, 0.10, 0.50};
constexpr glm::ivec2 kPicture = {1920, 1280};  // as in the paper
constexpr int kViews = 4;
constexpr std::size_t kBatch = 4;  // clouds in memory

struct PaperRow {
  double loss_percent;
  int depth;
  int nodes, leaves;
  double build_ms, traverse_ms;
};

/// Slomp et al., Geometry Instancing, Tables I and III, with times on an Intel Core i5-2540M at 2.6
/// GHz. "Actual loss" is 1 - oct(h) / n, and "nodes" are inner nodes (FORMULAS.md, "Octree
/// tables").
struct PaperSequence {
  std::string_view name;
  int poses, points;
  std::array<PaperRow, kDeltas.size()> rows;
};
constexpr std::array<PaperSequence, 5> kPaper = {{
    {"baseball",
     115,
     88'315,
     {{{0.65, 11, 192'299, 87'737, 28.47, 15.67},
       {3.60, 10, 107'161, 85'137, 21.21, 11.72},
       {32.6, 9, 47'638, 59'523, 13.17, 6.732}}}},
    {"basketball",
     114,
     87'003,
     {{{0.71, 11, 189'559, 86'383, 28.4, 15.05},
       {4.19, 10, 106'198, 83'361, 19.34, 11.60},
       {32.7, 9, 47'618, 58'579, 12.83, 6.417}}}},
    {"kick",
     150,
     101'931,
     {{{0.96, 11, 201'762, 100'948, 33.77, 16.22},
       {8.15, 10, 108'137, 93'625, 23.18, 14.24},
       {38.6, 9, 45'586, 62'551, 16.2, 7.458}}}},
    {"soccer-juggle",
     116,
     92'352,
     {{{0.61, 11, 206'292, 91'789, 30.36, 16.85},
       {3.38, 10, 117'056, 89'235, 21.08, 12.73},
       {30.9, 9, 53'249, 63'807, 13.62, 7.053}}}},
    {"soccer-shoot",
     60,
     60'976,
     {{{0.49, 11, 141'737, 60'676, 20.08, 10.55},
       {2.88, 10, 82'519, 59'217, 14.73, 9.137},
       {28.2, 9, 38'717, 43'802, 10.07, 5.076}}}},
}};

/// Sums over the poses for one delta.
struct Sums {
  std::map<int, int> depths;  ///< poses by depth
  double loss = 0.0, nodes = 0.0, leaves = 0.0;
  std::vector<double> build, traverse, recursive;  ///< ms of every run
};

void count_nodes(const SortedPoints& sorted, std::size_t n, double delta, Sums& sums) {
  const Result<int> depth = choose_depth(sorted.occupied, n, DepthRule::by_delta(delta));
  if (!depth) return;
  const auto end = sorted.occupied.begin() + *depth;
  ++sums.depths[*depth];
  sums.nodes += std::accumulate(sorted.occupied.begin(), end, 0.0);
  sums.leaves += *end;
  sums.loss += 1.0 - *end / static_cast<double>(n);
}

void add(std::vector<double>& to, const Timing& timing) { to.push_back(timing.median); }

void time_pose(const PointCloud& cloud, const Cube& cube, double delta, int runs, Sums& sums) {
  const DepthRule rule = DepthRule::by_delta(delta);
  const auto build = [&] {
    const auto points = sort_to_depth(cloud, cube, rule);
    return build_svo(points->sorted, points->depth);
  };
  const Svo svo = build();
  add(sums.build, measure(runs, build));
  add(sums.recursive,
      measure(runs, [&] { reference::RecursiveOctree(cloud, cube, delta, kMaxDepth); }));
  VoxelCut cut;
  Camera camera;
  camera.frame_bounds(bounds(cloud), static_cast<double>(kPicture.x) / kPicture.y);
  for (int view = 0; view < kViews; ++view) {
    add(sums.traverse, measure(runs, [&] { cut.run(svo, camera, kPicture, 1.0f); }));
    camera.orbit(2.0 * std::numbers::pi / kViews, 0.0);
  }
}

nlohmann::json to_json(const Sums& sums, double poses) {
  const Timing build = summarise(sums.build), recursive = summarise(sums.recursive);
  nlohmann::json depths = nlohmann::json::object();
  for (const auto& [depth, count] : sums.depths) depths[std::to_string(depth)] = count;
  return {{"poses_by_depth", depths},
          {"loss", sums.loss / poses},
          {"nodes", sums.nodes / poses},
          {"leaves", sums.leaves / poses},
          {"build_ms", bench::to_json(build)},
          {"recursive_ms", bench::to_json(recursive)},
          {"ratio", recursive.median / build.median},
          {"traverse_ms", bench::to_json(summarise(sums.traverse))}};
}

nlohmann::json to_json(const PaperRow& row) {
  return {{"loss", row.loss_percent / 100.0},
          {"depth", row.depth},
          {"nodes", row.nodes},
          {"leaves", row.leaves},
          {"build_ms", row.build_ms},
          {"traverse_ms", row.traverse_ms}};
}

}  // namespace

Result<nlohmann::json> measure_structure(const Dataset& dataset, const StructureOptions& options,
                                         const std::function<void()>& done) {
  const auto* paper =
      std::find_if(kPaper.begin(), kPaper.end(),
                   [&](const PaperSequence& sequence) { return sequence.name == dataset.name; });
  if (paper == kPaper.end()) {
    return fail(ErrorCode::argument, dataset.name + ": is not a sequence of the paper");
  }
  const std::vector<int> poses = spread(dataset.motion->poses, options.poses);
  const std::vector<int> timed = spread(static_cast<int>(poses.size()), options.timed_poses);
  std::array<Sums, kDeltas.size()> sums;
  std::vector<double> points;
  for (std::size_t begin = 0; begin < poses.size(); begin += kBatch) {
    const std::vector<int> some(
        poses.begin() + static_cast<std::ptrdiff_t>(begin),
        poses.begin() + static_cast<std::ptrdiff_t>(std::min(begin + kBatch, poses.size())));
    const std::vector<PointCloud> clouds = TRY(make_clouds(dataset, some));
    for (std::size_t i = 0; i < some.size(); ++i) {
      const PointCloud& cloud = clouds[i];
      const Cube cube = bounding_cube(bounds(cloud));
      const SortedPoints sorted = sort_points(cloud, cube);
      points.push_back(static_cast<double>(cloud.size()));
      const bool is_timed =
          std::find(timed.begin(), timed.end(), static_cast<int>(begin + i)) != timed.end();
      for (std::size_t k = 0; k < kDeltas.size(); ++k) {
        count_nodes(sorted, cloud.size(), kDeltas[k], sums[k]);
        if (is_timed) time_pose(cloud, cube, kDeltas[k], options.runs, sums[k]);
      }
      done();
    }
  }

  const double count = static_cast<double>(poses.size());
  auto rows = nlohmann::json::array();
  for (std::size_t k = 0; k < kDeltas.size(); ++k) {
    nlohmann::json row = to_json(sums[k], count);
    row["delta"] = kDeltas[k];
    row["paper"] = to_json(paper->rows[k]);
    rows.push_back(row);
  }
  const auto [least, most] = std::minmax_element(points.begin(), points.end());
  return nlohmann::json{{"dataset", dataset.name},
                        {"poses", dataset.motion->poses},
                        {"measured_poses", poses.size()},
                        {"timed_poses", timed.size()},
                        {"points",
                         {{"mean", std::accumulate(points.begin(), points.end(), 0.0) / count},
                          {"min", *least},
                          {"max", *most}}},
                        {"paper", {{"poses", paper->poses}, {"points", paper->points}}},
                        {"rows", rows}};
}

}  // namespace pointreel::bench
