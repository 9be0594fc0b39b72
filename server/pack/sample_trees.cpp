#include "server/pack/sample_trees.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

#include <tbb/parallel_for.h>

#include "codec/core/build.h"
#include "codec/package/grid.h"
#include "codec/segments/input.h"
#include "common/base/spread.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::size_t kMaxSegments = 4, kMaxFrames = 24;
/// Inner nodes of all trees together: about 8 million decisions, which take ten seconds to learn.
constexpr std::size_t kMaxNodes = 1'600'000;

Result<Svo> build(const SourceFrame& frame, const SegmentInput& input) {
  const Grid grid = TRY(input.grid_of(frame));
  const PointCloud& cloud = frame.cloud;
  if (cloud.empty()) return Svo{};
  const auto points = TRY(
      sort_to_depth(cloud, grid.cube,
                    coding_rule(std::get<OctreeOptions>(grid.encode.codec).depth, cloud.size())));
  return build_svo(points.sorted, points.depth);
}

Result<Svo> tree_of(SegmentInput& input, std::size_t frame) {
  const SegmentInput::Cloud loaded = TRY(input.take(frame));
  Result<Svo> tree = build(*loaded, input);
  if (!tree) return fail_at(input.name(frame), tree.error());
  return tree;
}

/// Trees spread over a segment: at most `frames`, at least `fewest`, and otherwise as many as have
/// `nodes` nodes together.
Result<std::vector<Svo>> sample_segment(SegmentInput input, std::size_t frames, std::size_t fewest,
                                        std::size_t nodes, const std::stop_token& stop) {
  TRY(input.find_shared_grid(stop));
  const Svo first = TRY(tree_of(input, 0));
  const std::size_t fit = nodes / std::max<std::size_t>(1, first.masks.size());
  const std::size_t count = std::min(input.size(), std::clamp(fit, fewest, frames));
  std::vector<Result<Svo>> trees(count, Svo{});
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    if (stop.stop_requested()) return;
    const std::size_t frame = spread_index(i, count, input.size());
    trees[i] = frame == 0 ? first : tree_of(input, frame);
  });
  std::vector<Svo> all;
  for (Result<Svo>& tree : trees) all.push_back(TRY(std::move(tree)));
  return all;
}

}  // namespace

Result<std::vector<Svo>> sample_trees(std::span<const CloudFrame> files, const PackOptions& options,
                                      const std::stop_token& stop) {
  const std::size_t length = options.segment_frames;
  const std::size_t segments = (files.size() + length - 1) / length;
  const std::size_t used = std::min(segments, kMaxSegments);
  const SourceFrames frames(files, options);
  std::vector<Svo> all;
  for (std::size_t i = 0; i < used && !stop.stop_requested(); ++i) {
    const std::size_t first = spread_index(i, used, segments) * length;
    SegmentInput input(frames, first, std::min(length, files.size() - first), options);
    auto trees = TRY(sample_segment(std::move(input), kMaxFrames / used, used == 1 ? 2 : 1,
                                    kMaxNodes / used, stop));
    all.insert(all.end(), std::move_iterator(trees.begin()), std::move_iterator(trees.end()));
  }
  return all;
}

}  // namespace pointreel
