#include "server/pack/input.h"

#include <atomic>
#include <utility>

#include <tbb/parallel_for.h>

#include "common/base/median.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::size_t kKeepBytes = std::size_t{512} << 20;

std::size_t memory_of(const PointCloud& cloud) {
  return cloud.positions.size() * sizeof(glm::vec3) + cloud.normals.size() * sizeof(glm::vec3) +
         cloud.colors.size() * sizeof(glm::u16vec3) + cloud.radii.size() * sizeof(float);
}

}  // namespace

Result<SourceFrame> SegmentInput::read(std::size_t frame) const {
  SourceFrame source{TRY(read_cloud_file(files_[frame])), {}};
  source.cleaning = clean_frame(source.cloud, options_);
  return source;
}

Result<SegmentInput::Extent> SegmentInput::read_extent(const std::stop_token& stop) {
  struct Frame {
    std::optional<Error> error;
    Box box;
    std::optional<PointLattice> lattice;
    std::size_t points = 0;
    CleanReport cleaning;
  };
  std::vector<Frame> frames(files_.size());
  std::atomic<std::size_t> kept_bytes = 0;
  tbb::parallel_for(std::size_t{0}, files_.size(), [&](std::size_t i) {
    if (stop.stop_requested()) return;
    Result<SourceFrame> loaded = read(i);
    if (!loaded) {
      frames[i].error = std::move(loaded.error());
      return;
    }
    frames[i] = {{},
                 bounds(loaded->cloud),
                 lattice_of(loaded->cloud),
                 loaded->cloud.size(),
                 loaded->cleaning};
    const std::size_t bytes = memory_of(loaded->cloud);
    if (kept_bytes.fetch_add(bytes) + bytes <= kKeepBytes) {
      kept_[i] = std::make_shared<const SourceFrame>(std::move(*loaded));
    }
  });
  Extent all;
  std::vector<double> cells;
  std::size_t frames_with_points = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Frame& frame = frames[i];
    if (frame.error) return tl::unexpected(*frame.error);
    if (frame.points == 0) continue;
    if (frame.cleaning.cleaned) cells.push_back(frame.cleaning.cell);
    ++frames_with_points;
    const bool first = all.box.empty();
    if (first) {
      all.lattice = frame.lattice;
    } else if (all.lattice) {
      all.lattice = frame.lattice ? common_lattice(*all.lattice, *frame.lattice) : std::nullopt;
    }
    if (first || frame.points > frames[all.largest].points) all.largest = i;
    all.box.grow(frame.box);
  }
  if (!cells.empty() && cells.size() == frames_with_points) {
    all.cell = median(std::move(cells));
  }
  return all;
}

Result<void> SegmentInput::find_shared_grid(const std::stop_token& stop) {
  if (options_.cube_per_frame) return {};
  Extent extent = TRY(read_extent(stop));
  if (extent.cell && cells_follow_points(options_)) {
    extent.lattice = lattice_for_cells(*extent.cell);
  } else if (extent.lattice && !options_.voxel) {
    const Cloud largest = TRY(look(extent.largest));
    if (!reaches(*extent.lattice, extent.box, largest->cloud, options_.encode)) {
      extent.lattice.reset();
    }
  }
  const Result<Grid> grid = grid_for(extent.box, options_, extent.lattice);
  if (!grid) return fail_at(files_.front().string(), grid.error());
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
