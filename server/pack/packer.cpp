#include "server/pack/packer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <fstream>
#include <mutex>
#include <new>
#include <utility>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include "codec/cloud_file.h"
#include "codec/octree/context_tables.h"
#include "codec/training/sequence_tables.h"
#include "common/base/tbb_executor.h"
#include "common/stream/manifest.h"
#include "pointreel/chunks.h"
#include "pointreel/draco.h"
#include "pointreel/geometry.h"
#include "pointreel/package.h"
#include "server/pack/grid.h"
#include "server/pack/input.h"
#include "server/pack/layer_writer.h"
#include "server/pack/output_folder.h"
#include "server/pack/pack_frame.h"
#include "server/pack/sample_trees.h"
#include "server/pack/trials.h"
#include "server/rate/frame_time_control.h"
#include "server/rate/rate_control.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kInterrupted = "interrupted, nothing was written";

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string default_name(const fs::path& output) {
  const fs::path normal = fs::absolute(output).lexically_normal();
  const fs::path last = normal.has_filename() ? normal.filename() : normal.parent_path().filename();
  return last.extension() == ".reel" ? last.stem().string() : last.string();
}

std::vector<std::string> layer_names(const EncodeOptions& options) {
  if (options.id() == Codec::draco) return {"full"};
  return {"base", "middle", "full"};
}

/// --force replaces packages, and nothing else that someone may have put there.
Result<void> may_replace_package(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_regular_file(folder / kManifestName, error)) {
    return fail("is not a package, --force replaces packages only: remove it yourself");
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const fs::path name = entry.path().filename();
    if (name != kManifestName && name.extension() != ".prs") {
      return fail(fmt::format("holds {}, which is no part of a package: remove it yourself",
                              name.string()));
    }
  }
  if (error) return fail(error.message());
  return {};
}

/// Packs one segment after another into a folder.
class Packer {
 public:
  Packer(const PackOptions& options, const PackListener& listener, std::vector<fs::path> files,
         fs::path folder)
      : options_(options),
        listener_(listener),
        files_(std::move(files)),
        folder_(std::move(folder)),
        limits_(options) {
    // Frames go side by side; what of a frame is parted goes to threads that have none.
    options_.encode.executor = tbb_executor();
    manifest_.name = options.name.empty() ? default_name(options.output) : options.name;
    manifest_.codec = name(options.encode.id());
    if (const auto* octree = std::get_if<OctreeOptions>(&options.encode.codec)) {
      manifest_.entropy = name(octree->entropy);
    }
    manifest_.fps = options.fps;
    manifest_.up = options.up;
    manifest_.layer_names = layer_names(options.encode);
    manifest_.duration_us = time_us(files_.size());
  }

  Result<PackSummary> run(int threads) {
    // What a client would refuse is refused before the work, not after it.
    if (const auto head = parse_manifest(write_manifest(manifest_)); !head) {
      return tl::unexpected(head.error());
    }
    if (listener_.begin) listener_.begin(static_cast<std::uint32_t>(files_.size()));
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    if (options_.train) {
      Result<void> learnt;
      arena.execute([&] { learnt = learn(); });
      if (!learnt) return tl::unexpected(learnt.error());
    }
    for (std::size_t first = 0; first < files_.size(); first += options_.segment_frames) {
      const std::size_t count =
          std::min<std::size_t>(options_.segment_frames, files_.size() - first);
      Result<void> packed;
      arena.execute([&] { packed = pack_segment(first, count, threads); });
      if (!packed) return tl::unexpected(packed.error());
    }
    return finish();
  }

 private:
  std::uint64_t time_us(std::size_t frame) const {
    return static_cast<std::uint64_t>(
        std::llround(static_cast<double>(frame) * 1e6 / options_.fps));
  }

  /// Learns context tables and makes them part of the package, if that makes it smaller.
  Result<void> learn() {
    const auto samples = sample_trees(files_, options_, listener_.stop);
    if (listener_.stop.stop_requested()) return fail(kInterrupted);
    if (!samples) return tl::unexpected(samples.error());
    const Result<SequenceTables> learnt = learn_tables(*samples, files_.size());
    if (!learnt) return tl::unexpected(learnt.error());
    tally_.summary.learnt = LearntTables{samples->size(), learnt->file.size(), learnt->saved_bytes};
    if (learnt->file.empty()) return {};
    auto tables = read_table_file(learnt->file);
    if (!tables) return tl::unexpected(tables.error());
    LayerWriter writer(folder_, "tables");
    writer.append({learnt->file, {}, {}});
    Result<LayerFile> file = writer.finish();
    if (!file) return fail_at(options_.output.string(), file.error());
    manifest_.tables = std::move(*file);
    std::get<OctreeOptions>(options_.encode.codec).tables = std::move(*tables);
    return {};
  }

  Result<void> pack_segment(std::size_t first, std::size_t count, int threads) {
    const std::span<const fs::path> files(files_.data() + first, count);
    SegmentInput input(files);
    std::optional<Grid> shared;
    if (!options_.cube_per_frame) {
      const Result<Box> box = input.read_bounds(listener_.stop);
      if (listener_.stop.stop_requested()) return fail(kInterrupted);
      if (!box) return tl::unexpected(box.error());
      const Result<Grid> grid = grid_for(*box, options_);
      if (!grid) return fail_at(files.front().string(), grid.error());
      shared = *grid;
    }
    const Grid* grid = shared ? &*shared : nullptr;
    if (!options_.bitrate) return write_segment(input, first, files, grid, threads);

    const Result<Trials> trials = Trials::create(input, files, grid, options_);
    if (!trials) return tl::unexpected(trials.error());
    const double seconds = static_cast<double>(count) / options_.fps;
    const double budget = *options_.bitrate / 8.0 * seconds;
    RateControl control(budget, trials->have_attributes(options_.encode));
    const Tally before = tally_;
    for (;;) {
      const Result<void> led = trials->run(control, listener_.stop);
      if (listener_.stop.stop_requested()) return fail(kInterrupted);
      if (!led) return led;
      limits_.begin_segment(control.finest(), control.choice());
      const Result<void> written = write_segment(input, first, files, grid, threads);
      if (!written) return written;
      const double bytes = static_cast<double>(tally_.summary.segments.back().bytes);
      if (bytes <= budget || !control.overshot(bytes)) break;
      // The frames that were tried were not like the others: the segment is written anew.
      remove_files(manifest_.segments.back().layers);
      manifest_.segments.pop_back();
      tally_ = before;
      again_ = true;
    }
    again_ = false;
    SegmentSummary& summary = tally_.summary.segments.back();
    summary.trials = control.trials();
    summary.within_rate = static_cast<double>(summary.bytes) <= budget;
    if (!summary.within_rate) {
      warn(fmt::format("frames {} to {} take {:.3g} Mbit/s at the coarsest, more than the bit rate",
                       first, first + count - 1, 1e-6 * summary.bits_per_second));
    }
    return {};
  }

  /// Encodes and writes all frames of a segment, as coarse as `limits_` says.
  Result<void> write_segment(SegmentInput& input, std::size_t first,
                             std::span<const fs::path> files, const Grid* shared, int threads) {
    Segment segment;
    segment.first_frame = static_cast<std::uint32_t>(first);
    if (shared != nullptr) segment.cube = shared->cube;
    SegmentSummary summary;
    summary.first_frame = segment.first_frame;
    summary.encode = limits_.of_segment(options_.encode);
    std::vector<LayerWriter> writers;
    for (const std::string& layer : manifest_.layer_names) {
      writers.emplace_back(folder_, fmt::format("{:05}.{}", first, layer));
    }

    // Frames are encoded side by side and written in order; the tokens bound how many are in
    // memory.
    std::optional<Error> error;
    Box segment_box;
    std::size_t next = 0;
    const auto take_next = [&](tbb::flow_control& flow) -> std::size_t {
      if (next < files.size() && !stopping(error)) return next++;
      flow.stop();
      return 0;
    };
    const auto encode = [&](std::size_t i) {
      return pack_frame(input, i, files[i], shared, options_, limits_);
    };
    const auto write = [&](Result<PackedFrame> frame) {
      if (!frame) set(error, frame.error());
      if (!frame || stopping(error)) return;
      segment_box.grow(frame->box);
      if (Result<void> written = write_frame(*frame, writers, segment, summary); !written) {
        set(error, written.error());
      }
    };
    tbb::parallel_pipeline(
        static_cast<std::size_t>(threads) + 2,
        tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, take_next) &
            tbb::make_filter<std::size_t, Result<PackedFrame>>(tbb::filter_mode::parallel, encode) &
            tbb::make_filter<Result<PackedFrame>, void>(tbb::filter_mode::serial_in_order, write));
    if (error) return tl::unexpected(*error);
    if (listener_.stop.stop_requested()) return fail(kInterrupted);

    if (options_.cube_per_frame) segment.cube = bounding_cube(segment_box);
    manifest_.bounds.grow(segment_box);
    for (LayerWriter& writer : writers) {
      Result<LayerFile> file = writer.finish();
      if (!file) return fail_at(options_.output.string(), file.error());
      summary.bytes += file->bytes;
      segment.layers.push_back(std::move(*file));
    }
    summary.bits_per_second =
        8.0 * static_cast<double>(summary.bytes) * options_.fps / summary.frames;
    manifest_.segments.push_back(std::move(segment));
    tally_.summary.segments.push_back(summary);
    return {};
  }

  bool stopping(const std::optional<Error>& error) {
    const std::lock_guard lock(error_mutex_);
    return error.has_value() || listener_.stop.stop_requested();
  }

  void set(std::optional<Error>& error, const Error& value) {
    const std::lock_guard lock(error_mutex_);
    if (!error) error = value;
  }

  Result<void> write_frame(const PackedFrame& frame, std::vector<LayerWriter>& writers,
                           Segment& segment, SegmentSummary& summary) {
    const EncodedFrame& encoded = frame.encoded;
    if (encoded.layers.size() > writers.size()) return fail("the codec made too many layers");
    static const Chunks<Bytes> kNone;
    for (std::size_t i = 0; i < writers.size(); ++i) {
      writers[i].append(i < encoded.layers.size() ? encoded.layers[i] : kNone);
    }
    manifest_.colors = manifest_.colors || frame.colors;
    manifest_.normals = manifest_.normals || frame.normals;
    segment.times_us.push_back(time_us(segment.first_frame + segment.points.size()));
    segment.points.push_back(encoded.source_points);

    const auto depth = static_cast<std::uint32_t>(encoded.depth);
    summary.depth_min = summary.frames == 0 ? depth : std::min(summary.depth_min, depth);
    summary.depth_max = std::max(summary.depth_max, depth);
    summary.max_error = std::max(summary.max_error, frame.max_error);
    summary.frames += 1;

    PackSummary& all = tally_.summary;
    all.frames += 1;
    all.points += encoded.source_points;
    all.coded_points += encoded.coded_points;
    all.geometry_bytes += frame.parts.geometry;
    all.color_bytes += frame.parts.colors;
    all.normal_bytes += frame.parts.normals;
    tally_.encode_ms.push_back(frame.encode_ms);
    if (frame.had_radii && !tally_.warned_of_radii) {
      warn("radii are not packed: players take them from the voxels");
      tally_.warned_of_radii = true;
    }
    for (const std::string& warning : frame.warnings) warn(warning);
    if (listener_.frame_done && !again_) listener_.frame_done();
    return {};
  }

  void warn(const std::string& line) {
    tally_.summary.warnings.push_back(line);
    if (listener_.warn && !again_) listener_.warn(line);
  }

  void remove_files(const std::vector<LayerFile>& layers) const {
    for (const LayerFile& file : layers) {
      std::error_code ignored;
      fs::remove(folder_ / file.path, ignored);
    }
  }

  /// Finest layers that no frame has, of shallow octrees, are not part of the package.
  void drop_unused_layers() {
    const auto unused = [](const Segment& segment) { return segment.layers.back().bytes == 0; };
    while (manifest_.layer_names.size() > 1 &&
           std::all_of(manifest_.segments.begin(), manifest_.segments.end(), unused)) {
      for (Segment& segment : manifest_.segments) {
        std::error_code ignored;
        fs::remove(folder_ / segment.layers.back().path, ignored);
        segment.layers.pop_back();
      }
      manifest_.layer_names.pop_back();
    }
  }

  Result<PackSummary> finish() {
    drop_unused_layers();
    PackSummary& summary = tally_.summary;
    for (std::size_t i = 0; i < summary.segments.size(); ++i) {
      const SegmentSummary& segment = summary.segments[i];
      summary.depth_min =
          i == 0 ? segment.depth_min : std::min(summary.depth_min, segment.depth_min);
      summary.depth_max = std::max(summary.depth_max, segment.depth_max);
      summary.max_error = std::max(summary.max_error, segment.max_error);
    }
    manifest_.depth_min = summary.depth_min;
    manifest_.depth_max = summary.depth_max;
    const std::string text = write_manifest(manifest_);
    if (const auto parsed = parse_manifest(text); !parsed) {
      return fail_at("the package would not be valid", parsed.error());
    }
    std::ofstream out(folder_ / kManifestName, std::ios::binary);
    out << text;
    out.close();
    if (!out) return fail_at(options_.output.string(), {"cannot be written, is the disk full?"});

    summary.bytes = text.size();
    for (const PackageFile* file : manifest_.files()) summary.bytes += file->bytes;
    summary.encode_ms = spread_of(std::move(tally_.encode_ms));
    summary.late_frames = limits_.late_frames();
    summary.codec = manifest_.codec;
    summary.entropy = manifest_.entropy;
    return std::move(summary);
  }

  /// What adds up over the segments, and goes back where one is written anew.
  struct Tally {
    PackSummary summary;
    std::vector<double> encode_ms;
    bool warned_of_radii = false;
  };

  PackOptions options_;  ///< with the tables that were learnt
  const PackListener& listener_;
  const std::vector<fs::path> files_;
  const fs::path folder_;
  Manifest manifest_;
  Tally tally_;
  FrameLimits limits_;
  bool again_ = false;  ///< a segment is being written anew: the listener has heard of its frames
  std::mutex error_mutex_;
};

}  // namespace

Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  const double median =
      values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
  return {median, values.front(), values.back()};
}

Result<PackSummary> pack(const PackOptions& options, const PackListener& listener) {
  const Clock::time_point start = Clock::now();
  try {
    Result<std::vector<fs::path>> files = list_cloud_files(options.inputs);
    if (!files) return tl::unexpected(files.error());
    Result<OutputFolder> folder = OutputFolder::create(
        options.output, options.force ? may_replace_package : OutputFolder::MayReplace{});
    if (!folder) return tl::unexpected(folder.error());
    const int threads = options.threads > 0 ? options.threads : tbb::info::default_concurrency();
    Packer packer(options, listener, std::move(*files), folder->path());
    Result<PackSummary> summary = packer.run(threads);
    if (!summary) return summary;
    if (const Result<void> published = folder->publish(); !published) {
      return tl::unexpected(published.error());
    }
    summary->seconds = seconds_since(start);
    return summary;
  } catch (const std::bad_alloc&) {
    return fail("not enough memory: try --threads 1");
  } catch (const std::exception& e) {
    return fail(e.what());
  }
}

}  // namespace pointreel
