#include "server/pack/packer.h"

#include <algorithm>
#include <chrono>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "codec/files/cloud_file.h"
#include "codec/package/manifest.h"
#include "codec/package/package_folder.h"
#include "codec/package/segment_writer.h"
#include "codec/package/standing.h"
#include "codec/segments/append_manifest.h"
#include "codec/segments/choose_cleaning.h"
#include "codec/segments/cleaning.h"
#include "codec/segments/coding_error.h"
#include "codec/segments/missing_normals.h"
#include "codec/segments/pack_segment.h"
#include "codec/segments/segment_packer.h"
#include "codec/segments/segment_warnings.h"
#include "common/base/try.h"
#include "common/file_system/output_folder.h"
#include "common/threads/stoppable.h"
#include "common/threads/tbb_executor.h"
#include "pointreel/codec.h"
#include "pointreel/package.h"
#include "server/pack/audio.h"
#include "server/pack/begin_manifest.h"
#include "server/pack/in_arena.h"
#include "server/pack/package_tables.h"
#include "server/pack/video_trial.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

using Clock = std::chrono::steady_clock;

/// Packs one segment after another into a folder.
class Packer {
 public:
  /// `trial`: because of which frames are packed as video, or null. It, `listener` and `sequence`
  /// outlive this object.
  Packer(const PackOptions& options, const PackListener& listener, const CloudSequence& sequence,
         const fs::path& folder, const VideoTrial* trial = nullptr)
      : options_(options),
        listener_(listener),
        sequence_(sequence),
        files_(sequence_.frames),
        trial_(trial) {
    options_.name = reel_name(options.name, options.output);
    if (options_.up_of_files) options_.up = up_of_frame(files_.front()).value_or(options_.up);
    manifest_ = begin_manifest(options_, sequence_);
    output_ = {folder, manifest_.layer_names, listener.frame_done, listener.stop, {}};
    summary_.lost_parts = sequence_.lost_parts;
    summary_.guesses = sequence_.guesses;
    if (has_times_of_files(options_, sequence_)) {
      if (!options_.keep_gaps) summary_.recorded_fps = options_.fps;
      output_.time_us = [this](std::size_t i) { return sequence_.times_us[i]; };
    }
  }

  /// Runs in the calling arena.
  Result<PackSummary> run() {
    // Refuses what a client would refuse before the work, not after it.
    TRY(parse_manifest(write_manifest(manifest_)));
    if (listener_.begin) listener_.begin(static_cast<std::uint32_t>(files_.size()));
    for (const std::string& line : sequence_.warnings) warn(line);
    if (options_.audio) {
      summary_.audio =
          TRY(write_audio(*options_.audio, output_.folder, manifest_.duration_us, listener_.stop,
                          [this](const std::string& line) { warn(line); }));
      manifest_.audio = summary_.audio->file;
    }
    if (options_.train) {
      const PackageTables tables =
          TRY(learn_package_tables(files_, options_, output_.folder, listener_.stop));
      summary_.learnt = tables.learnt;
      manifest_.tables = tables.file;
    }
    SegmentPacker packer(files_, options_, output_);
    for (std::size_t first = 0; first < files_.size(); first += options_.segment_frames) {
      const std::size_t count =
          std::min<std::size_t>(options_.segment_frames, files_.size() - first);
      TRY(add(TRY(packer.pack(static_cast<std::uint32_t>(first), count))));
    }
    summary_.late_frames = packer.late_frames();
    return finish();
  }

 private:
  void warn(const std::string& line) {
    summary_.warnings.push_back(line);
    if (listener_.warn) listener_.warn(line);
  }

  Result<void> add(PackedSegment segment) {
    if (trial_ != nullptr) TRY(trial_->holds_for(segment, options_));
    for (const std::string& line : warnings_.fresh(segment)) warn(line);
    const bool is_first = summary_.segments.empty();
    const SegmentSummary& added = segment.summary;
    summary_.frames += added.frames;
    summary_.points += segment.points;
    summary_.unreadable_frames += segment.unreadable_frames;
    add_cleaning(summary_.cleaning, segment.cleaning);
    for (const auto& [why, frames] : segment.not_cleaned) summary_.not_cleaned[why] += frames;
    summary_.coded_points += segment.coded_points;
    summary_.segment_bytes += added.bytes;
    summary_.scalar_bytes += segment.scalar_bytes;
    if (segment.parts) {
      if (!summary_.parts) summary_.parts.emplace();
      summary_.parts->geometry += segment.parts->geometry;
      summary_.parts->colors += segment.parts->colors;
      summary_.parts->normals += segment.parts->normals;
    }
    summary_.depth_min = is_first ? added.depth_min : std::min(summary_.depth_min, added.depth_min);
    summary_.depth_max = std::max(summary_.depth_max, added.depth_max);
    summary_.max_error = std::max(summary_.max_error, added.max_error);
    summary_.segments.push_back(added);
    encode_ms_.insert(encode_ms_.end(), segment.encode_ms.begin(), segment.encode_ms.end());
    return append_manifest(manifest_, manifest_of(std::move(segment), manifest_));
  }

  Result<PackSummary> finish() {
    for (const std::string& line : warnings_.rest()) warn(line);
    if (summary_.points + summary_.unreadable_frames == 0) warn("no frame has a point");
    for (const std::string& line : unused_steps(options_, manifest_.scalars)) warn(line);
    if (options_.up_of_files && !up_of_frame(files_.front())) {
      if (const auto line = standing_warning(manifest_.bounds, manifest_.up)) warn(*line);
    }
    summary_.bytes = TRY(finish_package(output_.folder, manifest_, options_.output));
    for (const PackageFile* file : manifest_.files()) summary_.bytes += file->bytes;
    summary_.duration_us = manifest_.duration_us;
    summary_.encode_ms = spread_of(std::move(encode_ms_));
    summary_.normals_estimated = manifest_.normals_estimated;
    summary_.video = options_.video.has_value();
    summary_.coding_error = manifest_.coding_error;
    if (manifest_.coding_error) summary_.peak = peak_of(manifest_);
    summary_.codec = manifest_.codec;
    summary_.entropy = manifest_.entropy;
    return std::move(summary_);
  }

  PackOptions options_;  ///< with a name, and with the tables that were learnt
  const PackListener& listener_;
  const CloudSequence& sequence_;
  const std::span<const CloudFrame> files_;
  const VideoTrial* const trial_;
  SegmentOutput output_;
  Manifest manifest_;
  PackSummary summary_;
  std::vector<double> encode_ms_;
  SegmentWarnings warnings_;
};

}  // namespace

Result<PackSummary> pack(const PackOptions& options, const PackListener& listener) {
  const Clock::time_point start = Clock::now();
  return in_arena(options.threads, [&]() -> Result<PackSummary> {
    CloudSequence sequence = TRY(list_cloud_frames(options.inputs, options.listing(listener.stop)));
    if (options.keep_gaps) sequence.keep_gaps(options.fps);
    if (!options.audio) warn_of_unpacked_audio(options.inputs, sequence.warnings);
    const auto make_folder = [&] {
      return OutputFolder::create(options.output,
                                  options.force ? may_replace_package : OutputFolder::MayReplace{});
    };
    std::optional<OutputFolder> folder(TRY(make_folder()));
    PackOptions chosen = options;
    // Frames are encoded in parallel; parts of a large frame go to threads that have no frame.
    chosen.encode.executor = stoppable(tbb_executor(), listener.stop, kInterrupted);
    choose_cleaning(sequence.frames, chosen);
    PackOptions as_octrees = chosen;
    auto trial = TRY(choose_video(sequence.frames, chosen, listener.stop));
    const bool by_trial = trial && chosen.video;
    choose_normals(sequence.frames, chosen);
    auto packed =
        Packer(chosen, listener, sequence, folder->path(), by_trial ? &*trial : nullptr).run();
    if (!packed && by_trial && packed.error().code == ErrorCode::limit) {
      // Another segment is not like the one that was tried.
      sequence.warnings.push_back("packed as octrees, because video does not suit all frames: " +
                                  packed.error().message);
      trial.reset();
      folder.reset();
      folder.emplace(TRY(make_folder()));
      choose_normals(sequence.frames, as_octrees);
      packed = Packer(as_octrees, listener, sequence, folder->path()).run();
    }
    if (!packed) return packed;
    TRY(folder->publish());
    packed->trial = std::move(trial);
    packed->seconds = std::chrono::duration<double>(Clock::now() - start).count();
    return packed;
  });
}

}  // namespace pointreel
