#include "client/bindings/frames/frame_cleaner.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "codec/package/encoding_options.h"
#include "common/base/concat.h"
#include "common/base/out_of_memory.h"
#include "common/threads/tbb_executor.h"

namespace pointreel {

Result<FrameCleaner> FrameCleaner::make(const Options& options) {
  const std::optional<double>& radius = options.clean.radius;
  if (radius && !(*radius > 0.0 && std::isfinite(*radius)))
    return fail(ErrorCode::argument, "radius is not a length above 0");
  if (std::max(options.before, options.after) > kMostCleanFrames)
    return fail(ErrorCode::argument, concat("at most ", kMostCleanFrames,
                                            " frames before and after one help to clean it"));
  return FrameCleaner(options);
}

Result<void> FrameCleaner::add(PointCloud cloud) {
  return or_out_of_memory([&]() -> Result<void> {
    window_.push_back(std::make_unique<const CleanedFrame>(
        clean_alone(std::move(cloud), options_.clean, tbb_executor())));
    return {};
  });
}

Result<SharedFrame> FrameCleaner::next() {
  const std::size_t waiting = window_.size() - next_;
  if (waiting == 0 || (!ended_ && waiting <= options_.after)) return SharedFrame();
  return or_out_of_memory([&]() -> Result<SharedFrame> {
    std::vector<const CleanedFrame*> around;
    const std::size_t end = std::min(window_.size(), next_ + options_.after + 1);
    for (std::size_t i = 0; i < end; ++i)
      if (i != next_) around.push_back(window_[i].get());
    EncodingOptions options;
    options.clean = options_.clean;
    options.encode.executor = tbb_executor();
    auto frame = std::make_shared<PointFrame>();
    frame->cloud = clean_frame(*window_[next_], around, options).cloud;
    if (next_ == options_.before)
      window_.pop_front();
    else
      ++next_;
    return frame;
  });
}

}  // namespace pointreel
