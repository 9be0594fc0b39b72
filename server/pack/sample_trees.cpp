#include "server/pack/sample_trees.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>
#include <utility>

#include <tbb/parallel_for.h>

#include "common/base/spread.h"
#include "common/octree/build.h"
#include "server/pack/grid.h"
#include "server/pack/input.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMostSegments = 4, kMostFrames = 24;
/// Inner nodes of all trees together: about 8 million decisions, some ten seconds of learning.
constexpr std::size_t kMostNodes = 1'600'000;

/// The frames of one segment.
class SegmentTrees {
 public:
  SegmentTrees(std::span<const fs::path> files, const PackOptions& options)
      : files_(files), options_(options), input_(files) {}

  Result<void> read_bounds(const std::stop_token& stop) {
    if (options_.cube_per_frame) return {};
    const Result<Box> box = input_.read_bounds(stop);
    if (!box) return tl::unexpected(box.error());
    const Result<Grid> grid = grid_for(*box, options_);
    if (!grid) return fail_at(files_.front().string(), grid.error());
    shared_ = *grid;
    return {};
  }

  Result<Svo> tree(std::size_t frame) {
    const auto at_fault = [&](const Error& error) {
      return fail_at(files_[frame].string(), error);
    };
    const Result<SegmentInput::Cloud> loaded = input_.take(frame);
    if (!loaded) return tl::unexpected(loaded.error());
    const Result<Grid> grid = shared_ ? *shared_ : grid_for(bounds((*loaded)->cloud), options_);
    if (!grid) return at_fault(grid.error());
    if ((*loaded)->cloud.empty()) return Svo{};
    const auto sorted = sort_to_depth((*loaded)->cloud, grid->cube,
                                      std::get<OctreeOptions>(grid->encode.codec).depth);
    if (!sorted) return at_fault(sorted.error());
    return build_svo(sorted->sorted, sorted->depth);
  }

 private:
  std::span<const fs::path> files_;
  const PackOptions& options_;
  SegmentInput input_;
  std::optional<Grid> shared_;
};

/// `frames` trees of a segment, spread over it, or as many as have `nodes` nodes; at least
/// `fewest`.
Result<std::vector<Svo>> sample_segment(std::span<const fs::path> files, const PackOptions& options,
                                        std::size_t frames, std::size_t fewest, std::size_t nodes,
                                        const std::stop_token& stop) {
  SegmentTrees segment(files, options);
  if (const auto read = segment.read_bounds(stop); !read) return tl::unexpected(read.error());
  const Result<Svo> first = segment.tree(0);
  if (!first) return tl::unexpected(first.error());
  const std::size_t fit = nodes / std::max<std::size_t>(1, first->masks.size());
  const std::size_t count = std::min(files.size(), std::clamp(fit, fewest, frames));
  std::vector<Result<Svo>> trees(count, Svo{});
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    if (stop.stop_requested()) return;
    const std::size_t frame = spread_index(i, count, files.size());
    trees[i] = frame == 0 ? *first : segment.tree(frame);
  });
  std::vector<Svo> all;
  for (Result<Svo>& tree : trees) {
    if (!tree) return tl::unexpected(tree.error());
    all.push_back(std::move(*tree));
  }
  return all;
}

}  // namespace

Result<std::vector<Svo>> sample_trees(std::span<const fs::path> files, const PackOptions& options,
                                      const std::stop_token& stop) {
  const std::size_t length = options.segment_frames;
  const std::size_t segments = (files.size() + length - 1) / length;
  const std::size_t used = std::min(segments, kMostSegments);
  std::vector<Svo> all;
  for (std::size_t i = 0; i < used && !stop.stop_requested(); ++i) {
    const std::size_t first = spread_index(i, used, segments) * length;
    auto trees =
        sample_segment(files.subspan(first, std::min(length, files.size() - first)), options,
                       kMostFrames / used, used == 1 ? 2 : 1, kMostNodes / used, stop);
    if (!trees) return tl::unexpected(trees.error());
    all.insert(all.end(), std::move_iterator(trees->begin()), std::move_iterator(trees->end()));
  }
  return all;
}

}  // namespace pointreel
