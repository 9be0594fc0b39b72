#include "server/pack/input.h"

#include <atomic>
#include <utility>

#include <tbb/parallel_for.h>

#include "codec/sequence/cloud_memory.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::size_t kKeepBytes = std::size_t{512} << 20;

}  // namespace

Result<SourceFrame> SegmentInput::read(std::size_t frame) const {
  SourceFrame source{TRY(read_cloud_frame(frames_[frame])), {}};
  place(source.cloud, options_.placement);
  source.cleaning = clean_frame(source.cloud, options_);
  return source;
}

Result<std::vector<FrameExtent>> SegmentInput::read_extents(const std::stop_token& stop) {
  std::vector<FrameExtent> frames(frames_.size());
  std::vector<std::optional<Error>> errors(frames_.size());
  std::atomic<std::size_t> kept_bytes = 0;
  tbb::parallel_for(std::size_t{0}, frames_.size(), [&](std::size_t i) {
    if (stop.stop_requested()) return;
    Result<SourceFrame> loaded = read(i);
    if (!loaded) {
      errors[i] = std::move(loaded.error());
      return;
    }
    frames[i] = extent_of(loaded->cloud, loaded->cleaning);
    const std::size_t bytes = memory_of(loaded->cloud);
    if (kept_bytes.fetch_add(bytes) + bytes <= kKeepBytes) {
      kept_[i] = std::make_shared<const SourceFrame>(std::move(*loaded));
    }
  });
  for (const auto& error : errors) {
    if (error) return tl::unexpected(*error);
  }
  return frames;
}

Result<void> SegmentInput::find_shared_grid(const std::stop_token& stop) {
  if (options_.cube_per_frame) return {};
  const std::vector<FrameExtent> extents = TRY(read_extents(stop));
  std::optional<Error> unread;
  const auto cloud_of = [&](std::size_t frame) -> Result<std::shared_ptr<const PointCloud>> {
    const Result<Cloud> read = look(frame);
    if (read) return std::shared_ptr<const PointCloud>(*read, &(*read)->cloud);
    unread = read.error();
    return tl::unexpected(*unread);
  };
  const Result<Grid> grid = grid_for_frames(extents, options_, cloud_of);
  if (unread) return tl::unexpected(*unread);
  if (!grid) return fail_at(frames_.front().name(), grid.error());
  shared_ = *grid;
  return {};
}

Result<Grid> SegmentInput::grid_of(const SourceFrame& frame) const {
  if (shared_) return *shared_;
  const PointCloud& cloud = frame.cloud;
  const Box box = bounds(cloud);
  if (frame.cleaning.cleaned && cells_follow_points(options_)) {
    return grid_for(box, options_, lattice_for_cells(frame.cleaning.cell));
  }
  std::optional<PointLattice> lattice = lattice_of(cloud);
  if (lattice && !options_.voxel && !reaches(*lattice, box, cloud, options_.encode)) {
    lattice.reset();
  }
  return grid_for(box, options_, lattice);
}

Result<SegmentInput::Cloud> SegmentInput::look(std::size_t frame) const {
  if (kept_[frame] != nullptr) return kept_[frame];
  return std::make_shared<const SourceFrame>(TRY(read(frame)));
}

Result<SegmentInput::Cloud> SegmentInput::take(std::size_t frame) {
  Result<Cloud> cloud = look(frame);
  kept_[frame].reset();
  return cloud;
}

}  // namespace pointreel
