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
#include "common/cloud/geometry.h"
#include "common/stream/package.h"
#include "server/pack/grid.h"
#include "server/pack/input.h"
#include "server/pack/layer_writer.h"
#include "server/pack/output_folder.h"
#include "server/pack/sample_trees.h"

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

struct PackedFrame {
  EncodedFrame encoded;
  PartSizes parts;
  Box box;
  double encode_ms = 0.0;
  bool colors = false, normals = false;  ///< coded
  bool had_radii = false;
  std::vector<std::string> warnings;
};

/// One frame from its file to its bytes. `shared` is the group's grid, null with a cube per frame.
Result<PackedFrame> pack_frame(SegmentInput& input, std::size_t index, const fs::path& file,
                               const Grid* shared, const PackOptions& options) {
  Result<LoadedCloud> loaded = input.take(index);
  if (!loaded) return tl::unexpected(loaded.error());
  PackedFrame frame;
  const PointCloud& cloud = loaded->cloud;
  frame.box = bounds(cloud);
  frame.colors = options.encode.colors && cloud.has_colors();
  frame.normals = options.encode.normals && cloud.has_normals();
  frame.had_radii = cloud.has_radii();
  for (const std::string& warning : loaded->warnings) {
    frame.warnings.push_back(fmt::format("{}: {}", file.string(), warning));
  }
  const Result<Grid> grid = shared != nullptr ? *shared : grid_for(frame.box, options);
  if (!grid) return fail_at(file.string(), grid.error());

  const Clock::time_point start = Clock::now();
  Result<EncodedFrame> encoded = encode_frame(cloud, grid->cube, grid->encode);
  frame.encode_ms = 1e3 * seconds_since(start);
  if (!encoded) return fail_at(file.string(), encoded.error());
  frame.encoded = std::move(*encoded);
  const Result<PartSizes> parts = measure_parts(frame.encoded, cloud, grid->cube, grid->encode);
  if (!parts) return fail_at(file.string(), parts.error());
  frame.parts = *parts;
  return frame;
}

/// Packs one segment after another into a folder.
class Packer {
 public:
  Packer(const PackOptions& options, const PackListener& listener, std::vector<fs::path> files,
         fs::path folder)
      : options_(options),
        listener_(listener),
        files_(std::move(files)),
        folder_(std::move(folder)) {
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
    summary_.learnt = LearntTables{samples->size(), learnt->file.size(), learnt->saved_bytes};
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
    Segment segment;
    segment.first_frame = static_cast<std::uint32_t>(first);
    if (!options_.cube_per_frame) {
      const Result<Box> box = input.read_bounds(listener_.stop);
      if (listener_.stop.stop_requested()) return fail(kInterrupted);
      if (!box) return tl::unexpected(box.error());
      const Result<Grid> grid = grid_for(*box, options_);
      if (!grid) return fail_at(files.front().string(), grid.error());
      shared = *grid;
      segment.cube = grid->cube;
    }
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
      if (next < count && !stopping(error)) return next++;
      flow.stop();
      return 0;
    };
    const auto encode = [&](std::size_t i) {
      return pack_frame(input, i, files[i], shared ? &*shared : nullptr, options_);
    };
    const auto write = [&](Result<PackedFrame> frame) {
      if (!frame) set(error, frame.error());
      if (!frame || stopping(error)) return;
      segment_box.grow(frame->box);
      if (Result<void> written = write_frame(*frame, writers, segment); !written) {
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
      segment.layers.push_back(std::move(*file));
    }
    manifest_.segments.push_back(std::move(segment));
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
                           Segment& segment) {
    const EncodedFrame& encoded = frame.encoded;
    if (encoded.layers.size() > writers.size()) return fail("the codec made too many layers");
    static const EncodedLayer kNone;
    for (std::size_t i = 0; i < writers.size(); ++i) {
      writers[i].append(i < encoded.layers.size() ? encoded.layers[i] : kNone);
    }
    manifest_.colors = manifest_.colors || frame.colors;
    manifest_.normals = manifest_.normals || frame.normals;
    segment.times_us.push_back(time_us(segment.first_frame + segment.points.size()));
    segment.points.push_back(encoded.source_points);
    const auto depth = static_cast<std::uint32_t>(encoded.depth);
    manifest_.depth_min = summary_.frames == 0 ? depth : std::min(manifest_.depth_min, depth);
    manifest_.depth_max = std::max(manifest_.depth_max, depth);

    summary_.frames += 1;
    summary_.points += encoded.source_points;
    summary_.coded_points += encoded.coded_points;
    summary_.geometry_bytes += frame.parts.geometry;
    summary_.color_bytes += frame.parts.colors;
    summary_.normal_bytes += frame.parts.normals;
    encode_ms_.push_back(frame.encode_ms);
    if (frame.had_radii && !warned_of_radii_) {
      warn("radii are not packed: players take them from the voxels");
      warned_of_radii_ = true;
    }
    for (const std::string& warning : frame.warnings) warn(warning);
    if (listener_.frame_done) listener_.frame_done();
    return {};
  }

  void warn(const std::string& line) {
    summary_.warnings.push_back(line);
    if (listener_.warn) listener_.warn(line);
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
    const std::string text = write_manifest(manifest_);
    if (const auto parsed = parse_manifest(text); !parsed) {
      return fail_at("the package would not be valid", parsed.error());
    }
    std::ofstream out(folder_ / kManifestName, std::ios::binary);
    out << text;
    out.close();
    if (!out) return fail_at(options_.output.string(), {"cannot be written, is the disk full?"});

    summary_.bytes = text.size();
    for (const PackageFile* file : manifest_.files()) summary_.bytes += file->bytes;
    summary_.encode_ms = spread_of(std::move(encode_ms_));
    summary_.depth_min = manifest_.depth_min;
    summary_.depth_max = manifest_.depth_max;
    summary_.codec = manifest_.codec;
    summary_.entropy = manifest_.entropy;
    return std::move(summary_);
  }

  PackOptions options_;  ///< with the tables that were learnt
  const PackListener& listener_;
  const std::vector<fs::path> files_;
  const fs::path folder_;
  Manifest manifest_;
  PackSummary summary_;
  std::vector<double> encode_ms_;
  bool warned_of_radii_ = false;
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
