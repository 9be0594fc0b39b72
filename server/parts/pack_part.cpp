#include "server/parts/pack_part.h"

#include <atomic>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include "codec/cloud_file.h"
#include "codec/sequence/segment_writer.h"
#include "common/base/tbb_executor.h"
#include "common/base/try.h"
#include "common/base/write_file.h"
#include "common/cloud/scalar_fields.h"
#include "common/stream/manifest.h"
#include "pointreel/codec.h"
#include "server/pack/in_arena.h"
#include "server/pack/read_package.h"
#include "server/pack/segment_packer.h"
#include "server/pack/segment_warnings.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

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

class PartPacker {
 public:
  PartPacker(const PackPlan& plan, PackOptions options, const PackListener& listener)
      : plan_(plan),
        options_(std::move(options)),
        listener_(listener),
        folder_(parts_folder(options_.output)) {
    options_.name = plan.name;
    if (options_.up_of_files)
      options_.up = up_of_file(plan.files.front().path).value_or(options_.up);
    options_.segment_frames = plan.segment_frames;
    options_.encode.executor = tbb_executor();
    static_cast<ReelHead&>(head_) = reel_head(options_);
    if (options_.encode.id() == Codec::octree) add_scalar_layer(head_.layer_names);
    head_.duration_us = presentation_time_us(plan.files.size(), options_.fps);
    head_.tables = plan.tables;
  }

  /// Runs in the calling arena.
  Result<PartReport> run(PartOf part, bool fail_fast) {
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
      frames += static_cast<std::uint32_t>(plan_.files_of(s).size());
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
          return fail(ErrorCode::cancelled, "interrupted; the same command goes on from here");
        }
        report_.failures.push_back(std::move(done.error()));
        if (fail_fast) break;
      }
    }
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

  /// The files must be those that the plan was made for.
  Result<std::vector<CloudFrame>> unchanged_files(std::uint32_t segment) const {
    std::vector<CloudFrame> files;
    for (const PlannedFile& file : plan_.files_of(segment)) {
      std::error_code error;
      const auto bytes = fs::file_size(file.path, error);
      if (error) {
        return fail(ErrorCode::io, fmt::format("{}: {}", file.path.string(), error.message()));
      }
      if (bytes != file.bytes) {
        return fail(ErrorCode::argument,
                    fmt::format("{}: has {} bytes and had {} when the plan was made; make the plan "
                                "again",
                                file.path.string(), bytes, file.bytes));
      }
      files.push_back({file.path});
    }
    return files;
  }

  Result<void> pack(std::uint32_t segment) {
    const std::uint32_t first_frame = plan_.first_frame(segment);
    const std::vector<CloudFrame> files = TRY(unchanged_files(segment));
    const WorkFolder work =
        TRY(WorkFolder::create(folder_ / fmt::format(".{:05}-{}", first_frame, own_name())));
    SegmentPacker packer(
        options_, {work.path(), head_.layer_names, listener_.frame_done, listener_.stop, {}});
    PackedSegment packed = TRY(packer.pack(files, first_frame));
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
  const PackListener& listener_;
  const fs::path folder_;
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
