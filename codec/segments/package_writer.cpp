#include "codec/segments/package_writer.h"

#include <cstddef>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "codec/package/cloud_memory.h"
#include "codec/package/manifest.h"
#include "codec/package/package_folder.h"
#include "codec/package/segment_writer.h"
#include "codec/segments/append_manifest.h"
#include "codec/segments/missing_normals.h"
#include "codec/segments/segment_packer.h"
#include "codec/segments/segment_warnings.h"
#include "common/base/try.h"
#include "common/file_system/output_folder.h"
#include "common/threads/stoppable.h"
#include "common/threads/tbb_executor.h"

namespace pointreel {
namespace {

constexpr std::size_t kMostSegmentBytes = std::size_t{512} << 20;
/// Half of what manifests can tell, so that the last frame's end can be told, too: 142 years.
constexpr std::uint64_t kLatest = std::uint64_t{1} << 52;

Result<void> check(const PackOptions& options) {
  if (!is_frame_rate(options.fps))
    return fail(ErrorCode::argument, fmt::format("{} frames per second are out of range: give {} "
                                                 "to {}",
                                                 options.fps, kMinFps, kMaxFps));
  if (options.segment_frames == 0)
    return fail(ErrorCode::argument, "a segment has at least one frame");
  if (options.video && options.cube_per_frame)
    return fail(ErrorCode::argument,
                "--cube frame does not go with --codec video, whose frames share a cube");
  return {};
}

}  // namespace

class PackageWriter::Impl {
 public:
  Impl(const PackOptions& options, OutputFolder folder)
      : options_(options), folder_(std::move(folder)) {
    options_.name = reel_name(options.name, options.output);
    static_cast<ReelHead&>(manifest_) = head_of(options_);
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
    LoadedCloud loaded;
    loaded.left_out = sanitize(cloud).dropped_positions;
    bytes_ += memory_of(cloud);
    loaded.cloud = std::move(cloud);
    segment_.push_back(std::move(loaded));
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
      tell(warnings_.rest());
      tell(unused_steps(options_, manifest_.scalars));
      manifest_.duration_us = next_time();
      TRY(finish_package(folder_.path(), manifest_, options_.output));
      TRY(folder_.publish());
      ended_ = true;
      return {};
    }());
  }

  void captured(std::uint64_t unix_us) { manifest_.captured_us = unix_us; }

  std::vector<std::string> take_warnings() { return std::exchange(lines_, {}); }

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

  void tell(const std::vector<std::string>& lines) {
    lines_.insert(lines_.end(), lines.begin(), lines.end());
  }

  Result<void> write_segment(const std::stop_token& stop) {
    const std::size_t first = frames_ - segment_.size();
    if (first == 0) choose_normals(segment_.front().cloud, options_);
    PackOptions options = options_;
    options.encode.executor = stoppable(tbb_executor(), stop, kInterrupted);
    SegmentPacker packer({}, options,
                         {folder_.path(), manifest_.layer_names, {}, stop, [&](std::size_t frame) {
                            return times_[frame - first];
                          }});
    PackedSegment packed = TRY(without_exceptions([&] {
      return packer.pack(static_cast<std::uint32_t>(first), std::exchange(segment_, {}));
    }));
    tell(warnings_.fresh(packed));
    TRY(append_manifest(manifest_, manifest_of(std::move(packed), manifest_)));
    times_.clear();
    bytes_ = 0;
    return {};
  }

  PackOptions options_;
  OutputFolder folder_;
  Manifest manifest_;
  SegmentWarnings warnings_;
  std::vector<std::string> lines_;
  // Of the segment that is not complete yet:
  std::vector<LoadedCloud> segment_;
  std::vector<std::uint64_t> times_;
  std::size_t bytes_ = 0;

  std::size_t frames_ = 0;
  std::uint64_t last_time_ = 0;
  bool timed_ = false;  ///< a time was given
  bool failed_ = false, ended_ = false;
};

PackageWriter::PackageWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PackageWriter::PackageWriter(PackageWriter&&) noexcept = default;
PackageWriter& PackageWriter::operator=(PackageWriter&&) noexcept = default;
PackageWriter::~PackageWriter() = default;

Result<PackageWriter> PackageWriter::create(const PackOptions& options) {
  TRY(check(options));
  std::error_code absent;
  if (!options.force && !std::filesystem::is_empty(options.output, absent) && !absent)
    return fail(ErrorCode::argument, options.output.string() +
                                         ": exists; name another folder, or replace it by --force");
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

void PackageWriter::captured(std::uint64_t unix_us) { impl_->captured(unix_us); }

Result<void> PackageWriter::finish(const std::stop_token& stop) { return impl_->finish(stop); }

std::vector<std::string> PackageWriter::take_warnings() { return impl_->take_warnings(); }

}  // namespace pointreel
