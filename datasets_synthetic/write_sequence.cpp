#include "datasets_synthetic/write_sequence.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <numeric>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "codec/files/ply.h"
#include "common/base/natural_order.h"
#include "common/base/try.h"
#include "common/process/progress.h"
#include "datasets_synthetic/write_folder.h"

namespace pointreel {
namespace {

namespace fs = std::filesystem;

/// Writes one frame; returns its number of points.
Result<std::size_t> write_frame(const Motion& motion, const SequenceJob& job, int number,
                                const fs::path& folder) {
  const auto cloud = sequence_frame(motion, job.options, number);
  if (!cloud) return fail_at(fmt::format("frame {}", number), cloud.error());
  TRY(write_ply(folder / fmt::format("frame_{:04}.ply", number), *cloud));
  return cloud->size();
}

/// Writes all frames and stores the number of points of each in `points`, which has one element per
/// frame.
Result<void> write_frames(const Motion& motion, const SequenceJob& job, const fs::path& folder,
                          std::vector<std::size_t>& points) {
  Progress progress("writing", points.size());
  std::mutex mutex;
  std::optional<Error> first_error;
  std::atomic<bool> failed{false};
  tbb::parallel_for(0, job.frames, [&](int number) {
    if (failed) return;
    const auto written = write_frame(motion, job, number, folder);
    if (written) {
      points[static_cast<std::size_t>(number)] = *written;
      progress.tick();
      return;
    }
    const std::lock_guard lock(mutex);
    if (!first_error) first_error = written.error();
    failed = true;
  });
  if (first_error) return tl::unexpected(*first_error);
  return {};
}

}  // namespace

Result<SequenceSummary> write_sequence(const Motion& motion, const SequenceJob& job) {
  const auto begin = std::chrono::steady_clock::now();
  const auto is_frame = [](std::string_view name) {
    return is_numbered(name, "frame_", 4, ".ply");
  };
  std::vector<std::size_t> points(static_cast<std::size_t>(job.frames));
  TRY(write_folder(job.output, job.force, is_frame, [&](const fs::path& folder) {
    return write_frames(motion, job, folder, points);
  }));
  SequenceSummary summary;
  const auto [min, max] = std::minmax_element(points.begin(), points.end());
  summary.min_points = *min;
  summary.max_points = *max;
  summary.mean_points =
      std::accumulate(points.begin(), points.end(), 0.0) / static_cast<double>(points.size());
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return summary;
}

}  // namespace pointreel
