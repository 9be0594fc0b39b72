#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include "codec/files/glb_write.h"
#include "codec/files/recording_writer.h"
#include "codec/package/manifest.h"
#include "codec/surface/normals.h"
#include "common/base/natural_order.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/file_system/output_folder.h"
#include "common/file_system/write_file.h"
#include "common/threads/stoppable.h"
#include "common/threads/tbb_executor.h"
#include "common/threads/without_exceptions.h"
#include "server/inspect/inspect.h"
#include "server/inspect/read_package.h"
#include "server/inspect/unpack_mesh.h"
#include "server/pack/audio.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

/// The least number of digits in the name of an unpacked frame.
constexpr std::size_t kDigits = 5;

/// The file that animations are written to.
constexpr const char* kAnimation = "animation.glb";

/// The file that all frames are recorded in.
constexpr const char* kRecording = "recording.mcap";

/// With --force, folders of unpacked frames are replaced, but nothing else.
Result<void> may_replace_frames(const fs::path& folder) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    const auto is_frame = [&name](const char* ending) {
      return is_numbered(name, "frame_", kDigits, ending);
    };
    constexpr std::array kEndings{".ply", ".pcd", ".las", ".npz", ".obj", ".glb"};
    if (name != kAnimation && name != kRecording && name != kUnpackedAudio &&
        std::none_of(kEndings.begin(), kEndings.end(), is_frame)) {
      return fail(ErrorCode::argument,
                  fmt::format("holds {}, and --force replaces only folders of unpacked frames; "
                              "remove it first",
                              name));
    }
  }
  if (error) return fail(ErrorCode::io, error.message());
  return {};
}

/// The frames of a package that were asked for.
class Unpacking {
 public:
  Unpacking(const UnpackOptions& options, const Manifest& manifest, const InspectListener& listener)
      : options_(options),
        manifest_(manifest),
        listener_(listener),
        executor_(stoppable(tbb_executor(), listener.stop, kInterrupted)),
        decoder_(options.max_memory) {}

  Result<UnpackReport> run() {
    const std::vector<std::uint32_t> shown = shown_frames(manifest_);
    TRY(check(static_cast<std::uint32_t>(shown.size())));
    if (manifest_.tables) {
      const auto read = decoder_.read_tables(options_.input, *manifest_.tables);
      if (!read) return fail_at(options_.input.shown(*manifest_.tables), read.error());
    }
    const std::size_t end = std::min(shown.size(), std::size_t{options_.last_frame} + 1);
    for (std::size_t i = options_.first_frame; i < end; ++i) frames_.push_back(shown[i]);
    OutputFolder folder = TRY(OutputFolder::create(
        options_.output, options_.force ? may_replace_frames : OutputFolder::MayReplace{}));
    report_.frames = static_cast<std::uint32_t>(frames_.size());
    if (listener_.begin) listener_.begin(report_.frames);
    TRY(write_all(folder.path()));
    if (listener_.stop.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);
    if (manifest_.audio) TRY(copy_audio(folder.path()));
    TRY(folder.publish());
    return report_;
  }

 private:
  /// `frames`: how many are shown.
  Result<void> check(std::uint32_t frames) const {
    const bool past_the_end = options_.last_frame != kToTheEnd && options_.last_frame >= frames;
    if (options_.layers == 0 || options_.first_frame > options_.last_frame || past_the_end ||
        (options_.first_frame >= frames && frames > 0)) {
      return fail(ErrorCode::argument,
                  fmt::format("{}: has {}, numbered from 0, and {}; ask for at least "
                              "one of each",
                              options_.input.shown(), counted(frames, "frame"),
                              counted(manifest_.layer_names.size(), "layer")));
    }
    if (options_.voxels && (manifest_.group_frames == 0 || options_.layers < 2)) {
      return fail(ErrorCode::argument,
                  fmt::format("{}: --voxels is for all layers of video; the points of other "
                              "packages are voxels already",
                              options_.input.shown()));
    }
    return {};
  }

  Result<void> copy_audio(const fs::path& folder) const {
    const fs::path source = TRY(options_.input.local(*manifest_.audio));
    std::error_code error;
    fs::copy_file(source, folder / kUnpackedAudio, error);
    if (!error) return {};
    return fail(
        ErrorCode::io,
        fmt::format("{}: cannot be copied to {}: {}", options_.input.shown(*manifest_.audio),
                    (folder / kUnpackedAudio).string(), why_not_written(error.value())));
  }

  Result<PointCloud> decode(std::uint32_t frame) const {
    PointCloud cloud = TRY(decode_points(frame));
    // Points that are stored outside the pictures of video have none, and those of unoriented
    // normals, which have no common side, may be coded as none.
    if (cloud.has_normals()) complete_normals(cloud, executor_);
    return cloud;
  }

  Result<PointCloud> decode_points(std::uint32_t frame) const {
    if (manifest_.group_frames > 0 && options_.layers > 1) {
      auto cloud = decoder_.decode_video(options_.input, manifest_, frame, options_.voxels);
      if (!cloud) return fail_at(place(frame), cloud.error());
      return cloud;
    }
    const auto layers = TRY(read_frame(options_.input, manifest_, frame, options_.layers));
    Result<DecodedFrame> decoded = decoder_.decode(layer_views(layers));
    if (!decoded) return fail_at(place(frame), decoded.error());
    return std::move(decoded->cloud);
  }

  std::string place(std::uint32_t frame) const {
    return fmt::format("{}: frame {}", options_.input.shown(), frame);
  }

  /// The mesh of a frame, counted. Called from any thread.
  Result<TriangleMesh> mesh(std::uint32_t frame) {
    PointCloud cloud = TRY(decode(frame));
    const bool has_points = !cloud.empty();
    MeshOptions options = options_.mesh->options;
    options.max_memory = options_.max_memory;
    Result<TriangleMesh> mesh = make_mesh(std::move(cloud), options, executor_);
    if (!mesh && mesh.error().code == ErrorCode::limit) {
      return fail(ErrorCode::limit, fmt::format("{}: {}; raise --frame-memory, or ask for a larger "
                                                "--cell",
                                                place(frame), mesh.error().message));
    }
    if (!mesh) return fail_at(place(frame), mesh.error());
    const std::lock_guard lock(mutex_);
    report_.triangles += mesh->triangles.size();
    if (has_points && mesh->empty()) ++report_.without_mesh;
    return mesh;
  }

  /// Called from any thread.
  void count_lost(const std::vector<LostValues>& lost) {
    const std::lock_guard lock(mutex_);
    for (const LostValues& one : lost) {
      const auto at =
          std::lower_bound(report_.lost.begin(), report_.lost.end(), one.field,
                           [](const LostValues& a, const std::string& b) { return a.field < b; });
      if (at != report_.lost.end() && at->field == one.field) {
        at->values += one.values;
      } else {
        report_.lost.insert(at, one);
      }
    }
  }

  Result<void> write(std::uint32_t frame, const fs::path& path) {
    if (!options_.mesh) {
      const PointCloud cloud = TRY(decode(frame));
      if (options_.format == PointsFormat::las) count_lost(lost_in_las(cloud));
      const Result<Bytes> bytes = cloud_bytes(cloud, options_.format);
      if (!bytes) return fail_at(place(frame), bytes.error());
      return write_file(path, *bytes);
    }
    return write_mesh(path, TRY(mesh(frame)), options_.mesh->format, manifest_.name, manifest_.up);
  }

  Result<void> write_all(const fs::path& folder) {
    if (options_.recording) return write_recording(folder);
    if (options_.mesh && options_.mesh->animation) return write_animation(folder);
    return write_files(folder);
  }

  Result<void> write_files(const fs::path& folder) {
    const std::size_t digits = std::max<std::size_t>(
        kDigits,
        fmt::format("{}", options_.first_frame + std::max<std::size_t>(frames_.size(), 1) - 1)
            .size());
    const char* ending =
        options_.mesh ? extension(options_.mesh->format) : extension(options_.format);
    std::optional<std::pair<std::uint32_t, Error>> first_error;
    for_each_frame(report_.frames, listener_, [&](std::uint32_t i) {
      const std::uint32_t frame = frames_[i];
      const fs::path path =
          folder / fmt::format("frame_{:0{}}{}", options_.first_frame + i, digits, ending);
      if (const Result<void> done = write(frame, path); !done) {
        const std::lock_guard lock(mutex_);
        if (!first_error || frame < first_error->first) first_error = {frame, done.error()};
      }
    });
    if (first_error) return tl::unexpected(first_error->second);
    return {};
  }

  /// One frame after another, so that the file does not depend on which is ready first. All threads
  /// work on each.
  Result<void> write_animation(const fs::path& folder) {
    GlbWriter glb(folder / kAnimation, manifest_.name, manifest_.up);
    for (std::uint32_t i = 0; i < report_.frames && !listener_.stop.stop_requested(); ++i) {
      const std::uint32_t frame = frames_[i];
      TRY(glb.add(TRY(mesh(frame)), frame_time_us(manifest_, frame)));
      if (listener_.frame_done) listener_.frame_done();
    }
    const bool to_the_end = frames_.empty() || frames_.back() + 1 == manifest_.frame_count();
    return glb.finish(to_the_end ? manifest_.duration_us
                                 : frame_time_us(manifest_, frames_.back() + 1));
  }

  /// Frames are decoded and compressed in parallel, and written in order. No more are under way
  /// than there are threads.
  Result<void> write_recording(const fs::path& folder) {
    // Messages have seconds in 31 bits.
    constexpr std::uint64_t kLatest = 2'000'000'000'000'000;
    const std::uint64_t captured = manifest_.captured_us.value_or(0);
    const std::uint64_t begin_us = captured < kLatest ? captured : 0;
    RecordingWriter recording(folder / kRecording);
    std::uint32_t next = 0;
    Result<void> written;
    const auto begin = [&](tbb::flow_control& control) {
      if (next < report_.frames && written && !listener_.stop.stop_requested())
        return frames_[next++];
      control.stop();
      return std::uint32_t{0};
    };
    const auto make = [&](std::uint32_t frame) -> Result<RecordedFrame> {
      const PointCloud cloud = TRY(decode(frame));
      return at_place(place(frame),
                      record_frame(cloud, begin_us + frame_time_us(manifest_, frame)));
    };
    const auto write = [&](const Result<RecordedFrame>& frame) {
      if (!written) return;
      written = frame ? recording.add(*frame) : tl::unexpected(frame.error());
      if (listener_.frame_done) listener_.frame_done();
    };
    tbb::parallel_pipeline(
        static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()),
        tbb::make_filter<void, std::uint32_t>(tbb::filter_mode::serial_in_order, begin) &
            tbb::make_filter<std::uint32_t, Result<RecordedFrame>>(tbb::filter_mode::parallel,
                                                                   make) &
            tbb::make_filter<Result<RecordedFrame>, void>(tbb::filter_mode::serial_in_order,
                                                          write));
    TRY(std::move(written));
    return recording.finish();
  }

  const UnpackOptions& options_;
  const Manifest& manifest_;
  const InspectListener& listener_;
  const Executor executor_;
  FrameDecoder decoder_;
  std::vector<std::uint32_t> frames_;  ///< to write
  std::mutex mutex_;
  UnpackReport report_;
};

}  // namespace

Result<UnpackReport> unpack(const UnpackOptions& options, const InspectListener& listener) {
  return without_exceptions([&]() -> Result<UnpackReport> {
    const Manifest manifest = TRY(options.input.manifest());
    return Unpacking(options, manifest, listener).run();
  });
}

}  // namespace pointreel
