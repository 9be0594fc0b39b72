#include "server/pack/packer.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <new>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include "codec/cloud_file.h"
#include "codec/sequence/layer_writer.h"
#include "codec/sequence/package_folder.h"
#include "codec/sequence/segment_writer.h"
#include "codec/training/sequence_tables.h"
#include "common/base/output_folder.h"
#include "common/base/tbb_executor.h"
#include "common/base/try.h"
#include "common/stream/manifest.h"
#include "pointreel/codec.h"
#include "pointreel/package.h"
#include "server/encode/unread_properties.h"
#include "server/pack/cleaning.h"
#include "server/pack/input.h"
#include "server/pack/pack_frame.h"
#include "server/pack/pack_segment.h"
#include "server/pack/sample_trees.h"
#include "server/pack/trials.h"
#include "server/rate/rate_control.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

using Clock = std::chrono::steady_clock;

/// Packs one segment after another into a folder.
class Packer {
 public:
  Packer(const PackOptions& options, const PackListener& listener, std::vector<fs::path> files,
         const fs::path& folder)
      : options_(options), listener_(listener), files_(std::move(files)), limits_(options) {
    if (options_.name.empty()) options_.name = default_reel_name(options.output);
    // Frames are encoded in parallel; parts of a large frame go to threads that have no frame.
    options_.encode.executor = tbb_executor();
    static_cast<ReelHead&>(manifest_) = reel_head(options_);
    manifest_.duration_us = presentation_time_us(files_.size(), options.fps);
    output_ = {folder, manifest_.layer_names, listener.frame_done, listener.stop};
  }

  /// Runs in the calling arena.
  Result<PackSummary> run() {
    // Refuses what a client would refuse before the work, not after it.
    TRY(parse_manifest(write_manifest(manifest_)));
    if (listener_.begin) listener_.begin(static_cast<std::uint32_t>(files_.size()));
    if (options_.train) TRY(learn());
    for (std::size_t first = 0; first < files_.size(); first += options_.segment_frames) {
      const std::size_t count =
          std::min<std::size_t>(options_.segment_frames, files_.size() - first);
      SegmentInput input({files_.data() + first, count}, options_);
      const Result<void> found = input.find_shared_grid(listener_.stop);
      if (listener_.stop.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);
      TRY(found);
      const auto first_frame = static_cast<std::uint32_t>(first);
      add(options_.bitrate ? TRY(pack_within_rate(input, first_frame))
                           : TRY(pack_segment(input, first_frame, options_, limits_, output_)));
    }
    return finish();
  }

 private:
  /// Learns context tables and adds them to the package, if that makes it smaller.
  Result<void> learn() {
    Result<std::vector<Svo>> sampled = sample_trees(files_, options_, listener_.stop);
    if (listener_.stop.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);
    const std::vector<Svo> samples = TRY(std::move(sampled));
    const SequenceTables learnt = TRY(learn_tables(samples, files_.size()));
    summary_.learnt = LearntTables{samples.size(), learnt.file.size(), learnt.saved_bytes};
    if (learnt.file.empty()) return {};
    std::get<OctreeOptions>(options_.encode.codec).tables = TRY(read_table_file(learnt.file));
    LayerWriter writer(output_.folder, "tables");
    writer.append({learnt.file, {}, {}});
    Result<LayerFile> file = writer.finish();
    if (!file) return fail_at(options_.output.string(), file.error());
    manifest_.tables = std::move(*file);
    return {};
  }

  /// Finds the finest options that meet the bit rate, and packs the segment with them.
  Result<PackedSegment> pack_within_rate(SegmentInput& input, std::uint32_t first_frame) {
    const Trials trials = TRY(Trials::create(input));
    const double seconds = static_cast<double>(input.size()) / options_.fps;
    const double budget = *options_.bitrate / 8.0 * seconds;
    RateControl control(budget, trials.have_attributes(options_.encode));
    SegmentOutput output = output_;
    for (;;) {
      const Result<void> tried = trials.run(control, listener_.stop);
      if (listener_.stop.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);
      TRY(tried);
      limits_.begin_segment(control.finest(), control.choice());
      PackedSegment packed = TRY(pack_segment(input, first_frame, options_, limits_, output));
      const auto bytes = static_cast<double>(packed.summary.bytes);
      // The trials encode only some of the frames. If all together take more, it starts again.
      if (bytes > budget && control.overshot(bytes)) {
        for (const LayerFile& file : packed.entry.layers) remove_file(file);
        output.frame_done = {};  // each frame counts once
        continue;
      }
      packed.summary.trials = control.trials();
      packed.summary.within_rate = bytes <= budget;
      if (!packed.summary.within_rate) {
        const std::string excess = fmt::format(
            "frames {} to {} take {:.3g} Mbit/s at the coarsest, more than the bit rate",
            first_frame, first_frame + input.size() - 1, 1e-6 * packed.summary.bits_per_second);
        if (!options_.best_effort) {
          return fail(ErrorCode::limit,
                      excess +
                          ": give a higher --bitrate, or --best-effort to pack them "
                          "nevertheless");
        }
        packed.warnings.push_back(excess);
      }
      return packed;
    }
  }

  void add(PackedSegment segment) {
    if (segment.had_radii && !warned_of_radii_) {
      warn("radii are not packed: players derive them from the voxels");
      warned_of_radii_ = true;
    }
    if (const std::string names = unread_.fresh(segment.unread); !names.empty())
      warn("PLY properties that are not packed: " + names);
    for (const std::string& warning : segment.warnings) warn(warning);

    manifest_.bounds.grow(segment.box);
    manifest_.colors |= segment.colors;
    manifest_.normals |= segment.normals;
    manifest_.segments.push_back(std::move(segment.entry));

    const bool is_first = summary_.segments.empty();
    const SegmentSummary& added = segment.summary;
    summary_.frames += added.frames;
    summary_.points += segment.points;
    add_cleaning(summary_.cleaning, segment.cleaning);
    summary_.coded_points += segment.coded_points;
    summary_.segment_bytes += added.bytes;
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
  }

  void warn(const std::string& line) {
    summary_.warnings.push_back(line);
    if (listener_.warn) listener_.warn(line);
  }

  void remove_file(const PackageFile& file) const {
    std::error_code ignored;
    fs::remove(output_.folder / file.path, ignored);
  }

  Result<PackSummary> finish() {
    manifest_.depth_min = summary_.depth_min;
    manifest_.depth_max = summary_.depth_max;
    manifest_.max_error = summary_.max_error;
    if (summary_.cleaning.frames > 0) manifest_.cleaning = summary_.cleaning;
    summary_.bytes = TRY(finish_package(output_.folder, manifest_, options_.output));
    for (const PackageFile* file : manifest_.files()) summary_.bytes += file->bytes;
    summary_.encode_ms = spread_of(std::move(encode_ms_));
    summary_.late_frames = limits_.late_frames();
    summary_.codec = manifest_.codec;
    summary_.entropy = manifest_.entropy;
    return std::move(summary_);
  }

  PackOptions options_;  ///< with a name, and with the tables that were learnt
  const PackListener& listener_;
  const std::vector<fs::path> files_;
  SegmentOutput output_;
  FrameLimits limits_;
  Manifest manifest_;
  PackSummary summary_;
  std::vector<double> encode_ms_;
  bool warned_of_radii_ = false;
  UnreadProperties unread_;
};

}  // namespace

Result<PackSummary> pack(const PackOptions& options, const PackListener& listener) try {
  const Clock::time_point start = Clock::now();
  std::vector<fs::path> files = TRY(list_cloud_files(options.inputs));
  OutputFolder folder = TRY(OutputFolder::create(
      options.output, options.force ? may_replace_package : OutputFolder::MayReplace{}));
  const int threads = options.threads > 0 ? options.threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  Packer packer(options, listener, std::move(files), folder.path());
  PackSummary summary = TRY(arena.execute([&] { return packer.run(); }));
  TRY(folder.publish());
  summary.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return summary;
} catch (const std::bad_alloc&) {
  return fail(ErrorCode::limit, "not enough memory; try --threads 1");
} catch (const std::exception& e) {
  return fail(e.what());
}

}  // namespace pointreel
