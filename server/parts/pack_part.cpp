#include "server/parts/pack_part.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include "codec/files/cloud_file.h"
#include "codec/package/manifest.h"
#include "codec/package/segment_writer.h"
#include "codec/segments/missing_normals.h"
#include "codec/segments/segment_packer.h"
#include "codec/segments/segment_warnings.h"
#include "common/base/try.h"
#include "common/file_system/write_file.h"
#include "common/threads/stoppable.h"
#include "common/threads/tbb_executor.h"
#include "pointreel/codec.h"
#include "server/inspect/read_package.h"
#include "server/pack/begin_manifest.h"
#include "server/pack/in_arena.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

constexpr const char* kGoesOn = "interrupted; the same command goes on from here";

/// A folder that is removed with everything in it.
class WorkFolder {
 public:
  static Result<WorkFolder> create(const fs::path& path) {
    std::error_code error;
    fs::create_directory(path, error);
    if (error) return fail(ErrorCode::io, fmt::format("{}: {}", path.string(), error.message()));
    return WorkFolder(path);
  }
  WorkFolder(WorkFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  WorkFolder& operator=(WorkFolder&&) = delete;
  ~WorkFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }

  const fs::path& path() const { return path_; }

 private:
  explicit WorkFolder(fs::path path) : path_(std::move(path)) {}

  fs::path path_;
};

Result<void> move_file(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) return fail(ErrorCode::io, fmt::format("{}: {}", to.string(), error.message()));
  return {};
}

/// A name that nobody else uses for its work, on any machine.
std::string own_name() {
  static std::atomic<unsigned> count = 0;
  char host[256] = {};
  if (gethostname(host, sizeof host - 1) != 0) host[0] = '\0';
  return fmt::format("{}-{}-{}", host, getpid(), count++);
}

CloudFrame cloud_frame(const PlannedFrame& planned) {
  return {planned.path, nullptr, planned.index.value_or(0), planned.time_us};
}

CloudSequence sequence_of(const PackPlan& plan) {
  CloudSequence sequence;
  for (const PlannedFrame& planned : plan.frames) sequence.frames.push_back(cloud_frame(planned));
  sequence.find_times();
  return sequence;
}

class PartPacker {
 public:
  PartPacker(const PackPlan& plan, PackOptions options, const PackListener& listener)
      : plan_(plan),
        options_(std::move(options)),
        listener_(listener),
        folder_(parts_folder(options_.output)),
        sequence_(sequence_of(plan)) {
    options_.name = plan.name;
    if (options_.up_of_files) options_.up = plan.up.value_or(options_.up);
    options_.segment_frames = plan.segment_frames;
    options_.encode.executor = stoppable(tbb_executor(), listener.stop, kGoesOn);
    if (options_.clean) options_.clean->noisy = plan.noisy;
  }

  /// Runs in the calling arena.
  Result<PartReport> run(PartOf part, bool fail_fast) {
    begin();
    if (plan_.tables) TRY(use_tables());
    std::vector<std::uint32_t> missing;
    std::uint32_t frames = 0;
    for (std::uint32_t s = part.first_segment(plan_.segments());
         s < part.end_segment(plan_.segments()); ++s) {
      if (is_there(s)) {
        ++report_.already;
        continue;
      }
      missing.push_back(s);
      frames += static_cast<std::uint32_t>(plan_.frames_of(s).size());
    }
    if (listener_.begin) listener_.begin(frames);
    for (const std::uint32_t segment : missing) {
      // Another process may have packed it meanwhile.
      if (is_there(segment)) {
        ++report_.already;
        continue;
      }
      if (Result<void> done = pack(segment); !done) {
        if (listener_.stop.stop_requested()) {
          return fail(ErrorCode::cancelled, kGoesOn);
        }
        report_.failures.push_back(std::move(done.error()));
        if (fail_fast) break;
      }
    }
    for (const std::string& line : warnings_.rest())
      if (listener_.warn) listener_.warn(line);
    return std::move(report_);
  }

 private:
  bool is_there(std::uint32_t segment) const {
    std::error_code ignored;
    return fs::exists(segment_manifest(folder_, plan_.first_frame(segment)), ignored);
  }

  Result<void> use_tables() {
    auto* octree = std::get_if<OctreeOptions>(&options_.encode.codec);
    if (octree == nullptr) return fail("the plan has context tables, but its codec has none");
    auto tables = read_tables(folder_, *plan_.tables);
    if (!tables) return fail_at((folder_ / plan_.tables->path).string(), tables.error());
    octree->tables = std::move(*tables);
    return {};
  }

  /// All parts look at the first frame. If it cannot be read, that is said where it is packed.
  void begin() {
    const auto first = unchanged_frames(0, 1);
    choose_normals(first ? *first : sequence_.frames, options_);
    head_ = begin_manifest(options_, sequence_);
    head_.tables = plan_.tables;
  }

  /// The source of frames must be what the plan was made for.
  static Result<void> check_unchanged(const PlannedFrame& planned) {
    const std::uint64_t bytes = TRY(bytes_of_source(planned.path));
    if (bytes == planned.bytes) return {};
    return fail(ErrorCode::argument,
                fmt::format("{}: has {} bytes and had {} when the plan was made; make the plan "
                            "again",
                            planned.path.string(), bytes, planned.bytes));
  }

  /// The frames of a recording, which remains open until another one is needed.
  Result<std::shared_ptr<const Recording>> recording_of(const PlannedFrame& planned) {
    if (recording_ == nullptr || planned.path != recording_path_) {
      TRY(check_unchanged(planned));
      recording_ = TRY(list_cloud_frames({planned.path}, options_.listing(listener_.stop)))
                       .frames.front()
                       .recording;
      recording_path_ = planned.path;
    }
    if (recording_ == nullptr || *planned.index >= recording_->size())
      return fail(ErrorCode::argument,
                  planned.path.string() +
                      ": no longer has the frames that it had when the plan was made; make the "
                      "plan again");
    return recording_;
  }

  /// All frames, of which those that a segment needs can be read.
  Result<std::vector<CloudFrame>> unchanged_frames(std::size_t first, std::size_t count) {
    std::vector<CloudFrame> frames = sequence_.frames;
    const std::size_t reach = options_.clean_frames;
    for (std::size_t i = first - std::min(first, reach);
         i < std::min(first + count + reach, frames.size()); ++i) {
      const PlannedFrame& planned = plan_.frames[i];
      CloudFrame& frame = frames[i];
      frame.reading = reading_;
      if (planned.index) {
        frame.recording = TRY(recording_of(planned));
      } else {
        TRY(check_unchanged(planned));
      }
    }
    return frames;
  }

  Result<void> pack(std::uint32_t segment) {
    const std::uint32_t first_frame = plan_.first_frame(segment);
    const std::size_t count = plan_.frames_of(segment).size();
    const std::vector<CloudFrame> frames = TRY(unchanged_frames(first_frame, count));
    const WorkFolder work =
        TRY(WorkFolder::create(folder_ / fmt::format(".{:05}-{}", first_frame, own_name())));
    SegmentOutput output{work.path(), head_.layer_names, listener_.frame_done, listener_.stop, {}};
    if (has_times_of_files(options_, sequence_))
      output.time_us = [this](std::size_t i) { return sequence_.times_us[i]; };
    SegmentPacker packer(frames, options_, output);
    PackedSegment packed = TRY(packer.pack(first_frame, count));
    for (const std::string& line : warnings_.fresh(packed)) {
      if (listener_.warn) listener_.warn(line);
    }
    report_.frames += packed.summary.frames;
    const Manifest manifest = manifest_of(std::move(packed), head_);
    const std::string text = write_manifest(manifest);
    TRY(parse_manifest(text));
    // The manifest comes last: it says that the layer files are there.
    for (const LayerFile& file : manifest.segments.front().layers)
      TRY(move_file(work.path() / file.path, folder_ / file.path));
    const fs::path unfinished = work.path() / kManifestName;
    TRY(write_file(unfinished, text));
    TRY(move_file(unfinished, segment_manifest(folder_, first_frame)));
    ++report_.packed;
    return {};
  }

  const PackPlan& plan_;
  PackOptions options_;
  const std::shared_ptr<const Reading> reading_ = std::make_shared<Reading>(options_.reading);
  const PackListener& listener_;
  const fs::path folder_;
  const CloudSequence sequence_;                ///< of the whole plan, with no recording open
  std::shared_ptr<const Recording> recording_;  ///< the newest, from `recording_path_`
  fs::path recording_path_;
  Manifest head_;  ///< without segments
  SegmentWarnings warnings_;
  PartReport report_;
};

}  // namespace

Result<PartReport> pack_part(const PackPlan& plan, PackOptions options, PartOf part, bool fail_fast,
                             const PackListener& listener) {
  const int threads = options.threads;
  PartPacker packer(plan, std::move(options), listener);
  return in_arena(threads, [&] { return packer.run(part, fail_fast); });
}

}  // namespace pointreel
