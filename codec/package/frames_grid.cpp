#include "codec/package/frames_grid.h"

#include <utility>
#include <vector>

#include "common/base/median.h"
#include "common/base/try.h"

namespace pointreel {

FrameExtent extent_of(const PointCloud& cloud, const CleanReport& cleaning) {
  return {bounds(cloud), lattice_of(cloud), cloud.size(), cleaning};
}

Result<Grid> grid_for_frames(
    std::span<const FrameExtent> frames, const EncodingOptions& options,
    const std::function<Result<std::shared_ptr<const PointCloud>>(std::size_t)>& cloud_of) {
  Box box;
  std::optional<PointLattice> lattice;  // on which all of them lie
  std::size_t largest = 0;              // the frame with the most points
  std::vector<double> cells;
  std::size_t frames_with_points = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FrameExtent& frame = frames[i];
    if (frame.points == 0) continue;
    if (frame.cleaning.cleaned) cells.push_back(frame.cleaning.cell);
    ++frames_with_points;
    const bool first = box.empty();
    if (first) {
      lattice = frame.lattice;
    } else if (lattice) {
      lattice = frame.lattice ? common_lattice(*lattice, *frame.lattice) : std::nullopt;
    }
    if (first || frame.points > frames[largest].points) largest = i;
    box.grow(frame.box);
  }
  const bool all_cleaned = !cells.empty() && cells.size() == frames_with_points;
  if (all_cleaned && cells_follow_points(options)) {
    lattice = lattice_for_cells(median(std::move(cells)));
  } else if (lattice && !options.voxel) {
    const std::shared_ptr<const PointCloud> cloud = TRY(cloud_of(largest));
    if (!reaches(*lattice, box, *cloud, options.encode)) lattice.reset();
  }
  return grid_for(box, options, lattice);
}

}  // namespace pointreel
