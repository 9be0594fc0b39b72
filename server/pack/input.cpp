#include "server/pack/input.h"

#include <atomic>
#include <utility>

#include <tbb/parallel_for.h>

#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::size_t kKeepBytes = std::size_t{512} << 20;

std::size_t memory_of(const PointCloud& cloud) {
  return cloud.positions.size() * sizeof(glm::vec3) + cloud.normals.size() * sizeof(glm::vec3) +
         cloud.colors.size() * sizeof(glm::u16vec3) + cloud.radii.size() * sizeof(float);
}

}  // namespace

Result<Box> SegmentInput::read_bounds(const std::stop_token& stop) {
  std::vector<Box> boxes(files_.size());
  std::vector<std::optional<Error>> errors(files_.size());
  std::atomic<std::size_t> kept_bytes = 0;
  tbb::parallel_for(std::size_t{0}, files_.size(), [&](std::size_t i) {
    if (stop.stop_requested()) return;
    Result<LoadedCloud> loaded = read_cloud_file(files_[i]);
    if (!loaded) {
      errors[i] = std::move(loaded.error());
      return;
    }
    boxes[i] = bounds(loaded->cloud);
    const std::size_t bytes = memory_of(loaded->cloud);
    if (kept_bytes.fetch_add(bytes) + bytes <= kKeepBytes) {
      kept_[i] = std::make_shared<const LoadedCloud>(std::move(*loaded));
    }
  });
  Box all;
  for (std::size_t i = 0; i < files_.size(); ++i) {
    if (errors[i]) return tl::unexpected(*errors[i]);
    all.grow(boxes[i]);
  }
  return all;
}

Result<void> SegmentInput::find_shared_grid(const std::stop_token& stop) {
  if (options_.cube_per_frame) return {};
  const Result<Grid> grid = grid_for(TRY(read_bounds(stop)), options_);
  if (!grid) return fail_at(files_.front().string(), grid.error());
  shared_ = *grid;
  return {};
}

Result<Grid> SegmentInput::grid_of(const Box& bounds) const {
  if (shared_) return *shared_;
  return grid_for(bounds, options_);
}

Result<SegmentInput::Cloud> SegmentInput::look(std::size_t frame) const {
  if (kept_[frame] != nullptr) return kept_[frame];
  return std::make_shared<const LoadedCloud>(TRY(read_cloud_file(files_[frame])));
}

Result<SegmentInput::Cloud> SegmentInput::take(std::size_t frame) {
  Result<Cloud> cloud = look(frame);
  kept_[frame].reset();
  return cloud;
}

}  // namespace pointreel
