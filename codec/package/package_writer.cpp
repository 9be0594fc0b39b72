#include "codec/package/package_writer.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "codec/core/scalar_fields.h"
#include "codec/package/cloud_memory.h"
#include "codec/package/collapse.h"
#include "codec/package/frames_grid.h"
#include "codec/package/manifest.h"
#include "codec/package/max_error.h"
#include "codec/package/package_folder.h"
#include "codec/package/segment_writer.h"
#include "codec/package/strays.h"
#include "common/base/try.h"
#include "common/file_system/output_folder.h"
#include "common/threads/tbb_executor.h"

namespace pointreel {
namespace {

constexpr std::size_t kMostSegmentBytes = std::size_t{512} << 20;
/// Half of what manifests can tell, so that the last frame's end can be told, too: 142 years.
constexpr std::uint64_t kLatest = std::uint64_t{1} << 52;

Result<void> check(const WriteOptions& options) {
  if (!is_frame_rate(options.fps))
    return fail(ErrorCode::argument, fmt::format("{} frames per second are out of range: give {} "
                                                 "to {}",
                                                 options.fps, kMinFps, kMaxFps));
  if (options.segment_frames == 0)
    return fail(ErrorCode::argument, "a segment has at least one frame");
  return {};
}

}  // namespace

class PackageWriter::Impl {
 public:
  Impl(const WriteOptions& options, OutputFolder folder)
      : options_(options), folder_(std::move(folder)) {
    if (options_.name.empty()) options_.name = default_reel_name(options.output);
    options_.encode.executor = tbb_executor();
    static_cast<ReelHead&>(manifest_) = reel_head(options_);
    if (options_.encode.id() == Codec::octree) add_scalar_layer(manifest_.layer_names);
  }

  /// Refuses what a client would refuse before the work, not after it.
  Result<void> check_head() const {
    TRY(parse_manifest(write_manifest(manifest_)));
    return {};
  }

  Result<void> add(PointCloud cloud, std::optional<std::uint64_t> time_us,
                   const std::stop_token& stop) {
    TRY(usable());
    const std::uint64_t time = time_us.value_or(next_time());
    if (time > kLatest)
      return fail(
          ErrorCode::argument,
          fmt::format("frame {} is shown at {} us, later than packages tell", frames_, time));
    if (frames_ > 0 && time < last_time_)
      return fail(ErrorCode::argument,
                  fmt::format("frame {} is shown at {} us, before the frame that precedes it",
                              frames_, time));
    sanitize(cloud);
    bytes_ += memory_of(cloud);
    segment_.push_back(std::move(cloud));
    times_.push_back(time);
    timed_ |= time_us.has_value();
    last_time_ = time;
    ++frames_;
    if (segment_.size() < options_.segment_frames && bytes_ < kMostSegmentBytes) return {};
    return remember(write_segment(stop));
  }

  Result<void> finish(const std::stop_token& stop) {
    TRY(usable());
    if (frames_ == 0) return fail(ErrorCode::argument, "a package has at least one frame");
    return remember([&]() -> Result<void> {
      if (!segment_.empty()) TRY(write_segment(stop));
      manifest_.duration_us = next_time();
      TRY(finish_package(folder_.path(), manifest_, options_.output));
      TRY(folder_.publish());
      ended_ = true;
      return {};
    }());
  }

 private:
  /// When the frame after the last one is shown, unless its time is given.
  std::uint64_t next_time() const {
    return timed_ ? last_time_ + presentation_time_us(1, options_.fps)
                  : presentation_time_us(frames_, options_.fps);
  }

  Result<void> usable() const {
    if (ended_) return fail(ErrorCode::argument, "the package is already complete");
    if (failed_) return fail(ErrorCode::argument, "the package could not be written before");
    return {};
  }

  Result<void> remember(Result<void> result) {
    failed_ |= !result;
    return result;
  }

  /// Calls body(0) and so on for the frames of the segment, in parallel.
  template <class Body>
  void for_each_frame(const Body& body) const {
    tbb_executor()(static_cast<int>(segment_.size()),
                   [&](int i) { body(static_cast<std::size_t>(i)); });
  }

  Result<void> write_segment(const std::stop_token& stop) {
    const std::size_t first = frames_ - segment_.size();
    std::vector<FrameExtent> extents(segment_.size());
    std::vector<std::string> strays(segment_.size());
    for_each_frame([&](std::size_t i) {
      extents[i] = extent_of(segment_[i]);
      strays[i] = strays_text(segment_[i]);
    });
    std::string far;  // of the first frame that has strays
    for (std::size_t i = 0; i < strays.size() && far.empty(); ++i)
      if (!strays[i].empty()) far = fmt::format("frame {}: {}", first + i, strays[i]);
    const Result<Grid> shared = grid_for_frames(extents, options_, [&](std::size_t i) {
      // Not owned: the frames stay until the segment is written.
      return Result<std::shared_ptr<const PointCloud>>(
          std::shared_ptr<const PointCloud>(std::shared_ptr<void>(), &segment_[i]));
    });
    if (!shared) return tl::unexpected(blame(far, shared.error()));
    const Grid& grid = *shared;
    std::vector<Result<EncodedFrame>> encoded(segment_.size());
    std::vector<double> errors(segment_.size());
    for_each_frame([&](std::size_t i) {
      if (stop.stop_requested()) return;
      encoded[i] = encode_frame(segment_[i], grid.cube, grid.encode);
      if (encoded[i]) errors[i] = geometry_error(segment_[i], grid.cube, encoded[i]->depth);
    });
    if (stop.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);
    SegmentWriter writer(folder_.path(), static_cast<std::uint32_t>(first), manifest_.layer_names);
    for (std::size_t i = 0; i < segment_.size(); ++i) {
      Result<void> whole;
      if (!encoded[i]) {
        whole = tl::unexpected(encoded[i].error());
      } else if (!options_.voxel) {
        whole = check_collapse(*encoded[i], segment_[i], grid, !far.empty());
      }
      if (!whole)
        return tl::unexpected(
            blame(far, at_place(fmt::format("frame {}", first + i), whole).error()));
      TRY(writer.append(*encoded[i], times_[i]));
      sum_up(segment_[i], extents[i], encoded[i]->depth, errors[i]);
    }
    manifest_.segments.push_back(TRY(writer.finish(grid.cube)));
    segment_.clear();
    times_.clear();
    bytes_ = 0;
    return {};
  }

  void sum_up(const PointCloud& cloud, const FrameExtent& extent, int depth, double error) {
    const auto level = static_cast<std::uint32_t>(depth);
    manifest_.depth_min = summed_up_ == 0 ? level : std::min(manifest_.depth_min, level);
    manifest_.depth_max = std::max(manifest_.depth_max, level);
    manifest_.max_error = std::max(manifest_.max_error.value_or(0.0), error);
    manifest_.bounds.grow(extent.box);
    manifest_.colors |= options_.encode.colors && cloud.has_colors();
    manifest_.normals |= options_.encode.normals && cloud.has_normals();
    if (const auto* octree = std::get_if<OctreeOptions>(&options_.encode.codec);
        octree != nullptr && octree->scalars)
      cover(manifest_.scalars, ranges_of(cloud));
    ++summed_up_;
  }

  WriteOptions options_;
  OutputFolder folder_;
  Manifest manifest_;
  // Of the segment that is not complete yet:
  std::vector<PointCloud> segment_;
  std::vector<std::uint64_t> times_;
  std::size_t bytes_ = 0;

  std::size_t frames_ = 0, summed_up_ = 0;
  std::uint64_t last_time_ = 0;
  bool timed_ = false;  ///< a time was given
  bool failed_ = false, ended_ = false;
};

PackageWriter::PackageWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PackageWriter::PackageWriter(PackageWriter&&) noexcept = default;
PackageWriter& PackageWriter::operator=(PackageWriter&&) noexcept = default;
PackageWriter::~PackageWriter() = default;

Result<PackageWriter> PackageWriter::create(const WriteOptions& options) {
  TRY(check(options));
  std::error_code absent;
  if (!options.force && !std::filesystem::is_empty(options.output, absent) && !absent)
    return fail(ErrorCode::argument,
                options.output.string() + ": exists; name another folder, or allow to replace it");
  OutputFolder folder = TRY(OutputFolder::create(
      options.output, options.force ? may_replace_package : OutputFolder::MayReplace{}));
  auto impl = std::make_unique<Impl>(options, std::move(folder));
  TRY(impl->check_head());
  return PackageWriter(std::move(impl));
}

Result<void> PackageWriter::add(PointCloud cloud, std::optional<std::uint64_t> time_us,
                                const std::stop_token& stop) {
  return impl_->add(std::move(cloud), time_us, stop);
}

Result<void> PackageWriter::finish(const std::stop_token& stop) { return impl_->finish(stop); }

}  // namespace pointreel
