#include "codec/segments/trials.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <tbb/parallel_for.h>

#include "common/base/spread.h"
#include "common/base/try.h"

namespace pointreel {

Result<Trials> Trials::create(const SegmentInput& input) {
  Trials trials;
  trials.frames_ = input.size();
  const std::size_t n = std::min(kFrames, input.size());
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t frame = spread_index(i, n, input.size());
    const SegmentInput::Cloud cloud = TRY(input.look(frame));
    const Result<Grid> grid = input.grid_of(*cloud);
    if (!grid) return fail_at(input.name(frame), grid.error());
    trials.samples_.push_back({input.name(frame), cloud, *grid});
  }
  return trials;
}

bool Trials::have_attributes(const EncodeOptions& options) const {
  return std::any_of(samples_.begin(), samples_.end(), [&](const Sample& sample) {
    const PointCloud& cloud = sample.cloud->cloud;
    return (options.normals && cloud.has_normals()) ||
           (options.id() == Codec::octree && options.colors && cloud.has_colors());
  });
}

Result<void> Trials::run(RateControl& control, const std::stop_token& stop) const {
  while (const std::optional<Coarsening> by = control.next()) {
    if (stop.stop_requested()) return {};
    std::vector<Result<EncodedFrame>> encoded(samples_.size());
    tbb::parallel_for(std::size_t{0}, samples_.size(), [&](std::size_t i) {
      const Sample& sample = samples_[i];
      encoded[i] = encode_frame(sample.cloud->cloud, sample.grid.cube,
                                coarsened(sample.grid.encode, control.finest(), *by));
    });
    double bytes = 0.0;
    int depth = 0;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      if (!encoded[i]) return fail_at(samples_[i].name, encoded[i].error());
      bytes += static_cast<double>(encoded[i]->size());
      depth = std::max(depth, encoded[i]->depth);
    }
    control.told(bytes * static_cast<double>(frames_) / static_cast<double>(samples_.size()),
                 depth);
  }
  return {};
}

}  // namespace pointreel
