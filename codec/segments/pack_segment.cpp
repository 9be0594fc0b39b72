#include "codec/segments/pack_segment.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include "codec/core/scalar_fields.h"
#include "codec/package/segment_writer.h"
#include "codec/segments/cleaning.h"
#include "codec/segments/coding_error.h"
#include "codec/segments/pack_group.h"
#include "common/base/try.h"
#include "common/file_system/output_folder.h"

namespace pointreel {
namespace {

/// Writes frames in order and sums them up.
class Writer {
 public:
  /// `compared`: the frame of the segment that is compared with its source.
  Writer(std::uint32_t first_frame, std::optional<std::size_t> compared, const PackOptions& options,
         const SegmentOutput& output)
      : fps_(options.fps),
        time_us_(output.time_us),
        first_frame_(first_frame),
        compared_(compared),
        options_(options),
        files_(output.folder, first_frame, output.layer_names) {
    segment_.summary.first_frame = first_frame;
  }

  /// Frames of video wait until their group is complete.
  Result<void> add(PackedFrame frame) {
    waiting_.push_back(std::move(frame));
    if (!options_.video || waiting_.size() == options_.video->group_frames) return write_waiting();
    return {};
  }

  /// `shared`: the cube of all frames, if they share one.
  Result<PackedSegment> finish(const std::optional<Grid>& shared) {
    TRY(write_waiting());
    SegmentSummary& summary = segment_.summary;
    segment_.entry = TRY(files_.finish(shared ? shared->cube : bounding_cube(segment_.box)));
    for (const LayerFile& file : segment_.entry.layers) summary.bytes += file.bytes;
    summary.bits_per_second = 8.0 * static_cast<double>(summary.bytes) * fps_ / summary.frames;
    return std::move(segment_);
  }

 private:
  Result<void> write_waiting() {
    if (waiting_.empty()) return {};
    if (options_.video) TRY(pack_group(waiting_, options_));
    TRY(compare());
    for (const PackedFrame& frame : waiting_) TRY(write(frame));
    waiting_.clear();
    return {};
  }

  Result<void> compare() {
    const std::size_t before = segment_.summary.frames;
    if (!compared_ || *compared_ < before || *compared_ >= before + waiting_.size()) return {};
    segment_.coding_error =
        TRY(coding_error(std::span(waiting_).first(*compared_ - before + 1), options_));
    return {};
  }

  Result<void> write(const PackedFrame& frame) {
    const EncodedFrame& encoded = frame.encoded;
    SegmentSummary& summary = segment_.summary;
    TRY(files_.append(encoded, time_us(first_frame_ + summary.frames)));

    const auto depth = static_cast<std::uint32_t>(encoded.depth);
    summary.depth_min = summary.frames == 0 ? depth : std::min(summary.depth_min, depth);
    summary.depth_max = std::max(summary.depth_max, depth);
    summary.max_error = std::max(summary.max_error, frame.max_error);
    summary.frames += 1;

    segment_.box.grow(frame.box);
    segment_.colors |= frame.colors;
    segment_.normals |= frame.normals;
    segment_.normals_estimated |= frame.normals_estimated;
    cover(segment_.scalars, frame.scalars);
    segment_.had_radii |= frame.had_radii;
    segment_.pixel_spacings = std::max(segment_.pixel_spacings, frame.pixel_spacings);
    segment_.had_scalars |= frame.had_scalars;
    segment_.scalar_bytes += encoded.scalar_bytes();
    segment_.unread.insert(frame.unread.begin(), frame.unread.end());
    segment_.unreadable_frames += frame.unreadable ? 1 : 0;
    segment_.points += encoded.source_points + frame.cleaning.removed;
    if (frame.cleaning.cleaned) {
      const CleanReport& of = frame.cleaning;
      add_cleaning(segment_.cleaning, {1, of.removed, of.spacing, of.noise, of.radius});
    } else if (cleaning_of(options_) != nullptr) {
      ++segment_.not_cleaned[frame.cleaning.why];
    }
    segment_.coded_points += encoded.coded_points;
    if (frame.parts) {
      if (!segment_.parts) segment_.parts.emplace();
      segment_.parts->geometry += frame.parts->geometry;
      segment_.parts->colors += frame.parts->colors;
      segment_.parts->normals += frame.parts->normals;
    }
    segment_.encode_ms.push_back(frame.encode_ms);
    segment_.warnings.insert(segment_.warnings.end(), frame.warnings.begin(), frame.warnings.end());
    return {};
  }

  std::uint64_t time_us(std::size_t frame) const {
    return time_us_ ? time_us_(frame) : presentation_time_us(frame, fps_);
  }

  const double fps_;
  const std::function<std::uint64_t(std::size_t)> time_us_;
  const std::uint32_t first_frame_;
  const std::optional<std::size_t> compared_;
  const PackOptions& options_;
  SegmentWriter files_;
  std::vector<PackedFrame> waiting_;
  PackedSegment segment_;
};

}  // namespace

ReelHead head_of(const PackOptions& options) {
  ReelHead head = reel_head(options);
  if (options.video) {
    head.codec = name(Codec::video);
    head.layer_names = {"base", "video"};
    head.group_frames = options.video->group_frames;
  } else if (options.encode.id() == Codec::octree) {
    add_scalar_layer(head.layer_names);
  }
  return head;
}

Manifest manifest_of(PackedSegment segment, const Manifest& head) {
  Manifest manifest;
  static_cast<ReelHead&>(manifest) = head;
  manifest.tables = head.tables;
  manifest.duration_us = head.duration_us;
  manifest.captured_us = head.captured_us;
  manifest.colors = segment.colors;
  manifest.normals = segment.normals;
  manifest.normals_estimated = segment.normals_estimated;
  manifest.scalars = std::move(segment.scalars);
  manifest.bounds = segment.box;
  manifest.depth_min = segment.summary.depth_min;
  manifest.depth_max = segment.summary.depth_max;
  if (head.group_frames == 0) manifest.max_error = segment.summary.max_error;
  manifest.coding_error = segment.coding_error;
  if (segment.cleaning.frames > 0) manifest.cleaning = segment.cleaning;
  segment.entry.first_frame = 0;
  manifest.segments.push_back(std::move(segment.entry));
  return manifest;
}

Result<PackedSegment> pack_segment(SegmentInput& input, std::uint32_t first_frame,
                                   const PackOptions& options, FrameLimits& limits,
                                   const SegmentOutput& output) {
  const std::optional<std::size_t> compared = compared_frame(first_frame, input.size());
  Writer writer(first_frame, compared, options, output);
  std::optional<Error> error;  // belongs to the last stage
  std::atomic<bool> failed = false;
  const auto stopping = [&] { return failed || output.stop.stop_requested(); };
  std::size_t next = 0;
  const auto take_next = [&](tbb::flow_control& flow) -> std::size_t {
    if (next < input.size() && !stopping()) return next++;
    flow.stop();
    return 0;
  };
  const auto encode = [&](std::size_t frame) {
    return pack_frame(input, frame, options, limits, frame == compared);
  };
  const auto write = [&](Result<PackedFrame> frame) {
    if (stopping()) return;
    const Result<void> written =
        frame ? writer.add(std::move(*frame)) : tl::unexpected(frame.error());
    if (!written) {
      error = written.error();
      failed = true;
    } else if (output.frame_done) {
      output.frame_done();
    }
  };
  // Frames are encoded in parallel and written in order. The tokens bound how many are in memory.
  const int threads = tbb::this_task_arena::max_concurrency();
  tbb::parallel_pipeline(
      static_cast<std::size_t>(threads) + 2,
      tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, take_next) &
          tbb::make_filter<std::size_t, Result<PackedFrame>>(tbb::filter_mode::parallel, encode) &
          tbb::make_filter<Result<PackedFrame>, void>(tbb::filter_mode::serial_in_order, write));
  if (error) return tl::unexpected(*error);
  if (output.stop.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);

  PackedSegment packed = TRY(writer.finish(input.shared_grid()));
  packed.summary.encode = limits.of_segment(options.encode);
  packed.video = options.video.has_value();
  return packed;
}

}  // namespace pointreel
