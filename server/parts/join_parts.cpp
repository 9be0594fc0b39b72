#include "server/parts/join_parts.h"

#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "codec/package/package_folder.h"
#include "codec/segments/append_manifest.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/file_system/output_folder.h"
#include "pointreel/package.h"
#include "server/pack/audio.h"
#include "server/pack/link_or_copy.h"
#include "server/parts/plan.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

/// The manifest of a segment; nothing if the segment is not there.
Result<std::optional<Manifest>> read_segment(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return std::nullopt;
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  Manifest manifest = TRY(at_place(path.string(), parse_manifest(text)));
  if (manifest.segments.size() != 1)
    return fail(path.string() + ": does not have exactly one segment");
  return manifest;
}

/// Segments in order, made into one manifest.
Result<Manifest> read_segments(const PackPlan& plan, const fs::path& folder) {
  std::optional<Manifest> whole;
  std::uint32_t missing = 0, first_missing = 0;
  for (std::uint32_t s = 0; s < plan.segments(); ++s) {
    const fs::path path = segment_manifest(folder, plan.first_frame(s));
    std::optional<Manifest> segment = TRY(read_segment(path));
    if (!segment) {
      if (missing++ == 0) first_missing = plan.first_frame(s);
      continue;
    }
    if (segment->frame_count() != plan.frames_of(s).size()) {
      return fail(fmt::format("{}: has {}, and the plan {}", path.string(),
                              counted(segment->frame_count(), "frame"), plan.frames_of(s).size()));
    }
    if (!whole) {
      whole = manifest_before(*segment);
      whole->duration_us = segment->duration_us;
    }
    TRY(at_place(path.string(), append_manifest(*whole, std::move(*segment))));
  }
  if (missing > 0) {
    return fail(ErrorCode::not_found,
                fmt::format("{}: {} of {} missing, the first at frame {}; run pack part until none "
                            "is",
                            folder.string(), missing,
                            counted(plan.segments(), "segment is", "segments are"), first_missing));
  }
  return std::move(*whole);
}

/// Puts a file into the package. It stays where it was, so that nothing is lost if this process
/// ends before the package is complete.
Result<void> put(const fs::path& from, const fs::path& to, const PackageFile& file) {
  std::error_code error;
  const auto bytes = fs::file_size(from, error);
  if (!error && bytes != file.bytes) {
    return fail(
        fmt::format("{}: has {} bytes instead of {}; remove the manifest of its segment, "
                    "and run pack part again",
                    from.string(), bytes, file.bytes));
  }
  return link_or_copy(from, to);
}

}  // namespace

Result<JoinReport> join_parts(const fs::path& output, bool force) {
  const PackPlan plan = TRY(read_plan(output));
  const fs::path parts = parts_folder(output);
  Manifest manifest = TRY(read_segments(plan, parts));
  manifest.name = plan.name;
  OutputFolder folder = TRY(OutputFolder::create(
      output, plan.force || force ? may_replace_package : OutputFolder::MayReplace{}));
  for (const PackageFile* file : manifest.files())
    TRY(put(parts / file->path, folder.path() / file->path, *file));
  JoinReport report{manifest.frame_count(), plan.segments(), 0};
  if (plan.audio) {
    report.audio =
        TRY(write_audio(*plan.audio, folder.path(), manifest.duration_us, {},
                        [&](const std::string& line) { report.warnings.push_back(line); }));
    manifest.audio = report.audio->file;
  }
  report.bytes = TRY(finish_package(folder.path(), manifest, output));
  for (const PackageFile* file : manifest.files()) report.bytes += file->bytes;
  TRY(folder.publish());
  std::error_code ignored;
  fs::remove_all(parts, ignored);
  return report;
}

}  // namespace pointreel
