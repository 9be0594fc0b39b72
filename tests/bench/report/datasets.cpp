#include "tests/bench/report/datasets.h"

#include <algorithm>
#include <mutex>
#include <optional>

#include <tbb/parallel_for.h>

#include "common/base/spread.h"
#include "datasets_synthetic/closest_point.h"

namespace pointreel::bench {
namespace {

constexpr int kGridBits = 10;
constexpr int kScanBits = 11;  // the depth for delta = 2 % in Slomp et al., Table III

Dataset scanned(const char* name) {
  return {name, find_motion(name), {}, {name}, kGridBits, kScanBits};
}

}  // namespace

std::vector<Dataset> scanned_datasets() {
  return {scanned("baseball"), scanned("basketball"), scanned("kick"), scanned("soccer-juggle"),
          scanned("soccer-shoot")};
}

Dataset dense_dataset() {
  const Motion* motion = find_motion("kick");
  SequenceOptions options;
  options.voxels = voxel_grid(sequence_bounds(*motion, options.fps, motion->poses), kGridBits);
  return {"kick, dense", motion,   options, {"kick", "--voxelize", std::to_string(kGridBits)},
          kGridBits,     kGridBits};
}

std::vector<int> spread(int n, int count) {
  std::vector<int> numbers;
  const auto places = static_cast<std::size_t>(std::min(count, n));
  for (std::size_t i = 0; i < places; ++i) {
    numbers.push_back(static_cast<int>(spread_index(i, places, static_cast<std::size_t>(n))));
  }
  return numbers;
}

Result<std::vector<PointCloud>> make_clouds(const Dataset& dataset, const std::vector<int>& poses) {
  std::vector<PointCloud> clouds(poses.size());
  std::mutex mutex;
  std::optional<Error> first_error;
  tbb::parallel_for(std::size_t{0}, poses.size(), [&](std::size_t i) {
    auto cloud = sequence_frame(*dataset.motion, dataset.options, poses[i]);
    if (cloud) {
      clouds[i] = std::move(*cloud);
    } else {
      const std::lock_guard lock(mutex);
      first_error = cloud.error();
    }
  });
  if (first_error) return fail_at(dataset.name, *first_error);
  return clouds;
}

Result<DistanceSummary> distance_to_truth(const Dataset& dataset, int pose,
                                          const PointCloud& cloud) {
  const Body body = pose_body(frame_pose(*dataset.motion, dataset.options, pose));
  const auto grid = SurfaceGrid::build(body.surface);
  if (!grid) return fail_at(dataset.name, grid.error());
  const auto& voxels = dataset.options.voxels;
  if (!voxels) return summarize(true_distances(*grid, cloud));
  PointCloud metres;
  metres.origin = voxels->origin + voxels->voxel * cloud.origin;
  const auto voxel = static_cast<float>(voxels->voxel);
  for (const glm::vec3& p : cloud.positions) metres.positions.push_back(voxel * p);
  return summarize(true_distances(*grid, metres));
}

}  // namespace pointreel::bench
