#include "server/edit/join_packages.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "codec/audio/audio_time.h"
#include "codec/core/json_fields.h"
#include "codec/package/package_folder.h"
#include "codec/segments/append_manifest.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/file_system/output_folder.h"
#include "server/edit/put_segment.h"
#include "server/edit/splice_sound.h"

namespace pointreel {
namespace {

/// How much the nominal frame rates may differ, as a share of the higher one: those of recordings
/// are measured.
constexpr double kMaxRateDifference = 0.1;

bool same_fields(const Manifest& a, const Manifest& b) {
  return std::is_permutation(
      a.scalars.begin(), a.scalars.end(), b.scalars.begin(), b.scalars.end(),
      [](const ScalarRange& x, const ScalarRange& y) { return x.name == y.name; });
}

/// What keeps the two apart, besides that for which append_manifest looks.
Result<void> check_alike(const Manifest& whole, const Manifest& next) {
  const auto differ = [](std::string what) {
    return fail(ErrorCode::argument, "the two reels have different " + std::move(what));
  };
  if (std::abs(whole.fps - next.fps) > kMaxRateDifference * std::max(whole.fps, next.fps)) {
    return differ(
        fmt::format("frame rates, {} and {} (pack --fps sets the rate, and spaces frames evenly)",
                    number_text(whole.fps), number_text(next.fps)));
  }
  // What has no points has no attributes.
  if (whole.bounds.empty() || next.bounds.empty()) return {};
  for (const auto& [what, here, there] :
       {std::tuple("colours", whole.colors, next.colors),
        std::tuple("normals (pack --normals estimate adds them)", whole.normals, next.normals)}) {
    if (here != there) {
      return fail(ErrorCode::argument, fmt::format("only {} of the two reels has {}",
                                                   here ? "the first" : "the second", what));
    }
  }
  return same_fields(whole, next) ? Result<void>() : differ("scalar fields");
}

/// A package among those that are joined.
struct Part {
  std::size_t end_segment = 0;  ///< in the whole
  std::uint64_t begin_us = 0, end_us = 0;
  std::optional<AudioFile> audio;
};

/// The manifests of all packages, made into one. Files have the names that they have there.
struct Whole {
  Manifest manifest;
  std::vector<Part> parts;

  Result<void> add(Manifest next) {
    if (parts.empty()) manifest = manifest_before(next);
    TRY(check_alike(manifest, next));
    Part part;
    part.begin_us = manifest.duration_us;
    part.end_us = part.begin_us + next.duration_us;
    if (part.end_us > kMaxInteger)
      return fail(ErrorCode::limit, "the frames before it take so long that no time is left");
    part.audio = next.audio;
    for (Segment& segment : next.segments)
      for (std::uint64_t& time : segment.times_us) time += part.begin_us;
    TRY(append_manifest(manifest, std::move(next)));
    manifest.duration_us = part.end_us;
    part.end_segment = manifest.segments.size();
    parts.push_back(std::move(part));
    return {};
  }
};

Result<Whole> read_all(const JoinOptions& options) {
  Whole whole;
  for (const PackageFiles& input : options.inputs) {
    const std::string place = whole.parts.empty()
                                  ? input.shown()
                                  : fmt::format("{}: cannot follow {}", input.shown(),
                                                options.inputs[whole.parts.size() - 1].shown());
    Manifest manifest = TRY(input.manifest());
    TRY(at_place(place, whole.add(std::move(manifest))));
  }
  return whole;
}

Result<std::optional<AudioFile>> join_sound(const JoinOptions& options,
                                            const std::vector<Part>& parts,
                                            const std::filesystem::path& folder,
                                            const std::stop_token& stop) {
  std::vector<SoundPiece> pieces;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Part& part = parts[i];
    const std::uint64_t begin = first_sample_from(part.begin_us);
    const std::uint64_t end = first_sample_from(part.end_us);
    if (!part.audio || begin == end) continue;
    const PackageFiles& input = options.inputs[i];
    pieces.push_back({TRY(input.local(*part.audio)), input.shown(*part.audio), part.audio->bytes, 0,
                      begin, end});
  }
  return splice_sound(pieces, folder, stop);
}

}  // namespace

Result<JoinedPackages> join_packages(const JoinOptions& options, const std::stop_token& stop) {
  Whole whole = TRY(read_all(options));
  Manifest& manifest = whole.manifest;
  manifest.name = reel_name(options.name, options.output);
  OutputFolder folder = TRY(OutputFolder::create(
      options.output, options.force ? may_replace_package : OutputFolder::MayReplace{}));
  std::size_t segment = 0;
  for (std::size_t i = 0; i < whole.parts.size(); ++i) {
    for (; segment < whole.parts[i].end_segment; ++segment) {
      if (stop.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);
      TRY(put_segment(options.inputs[i], folder.path(), manifest.layer_names,
                      manifest.segments[segment]));
    }
  }
  if (manifest.tables)
    TRY(put_file(options.inputs.front(), *manifest.tables, folder.path(), manifest.tables->path));
  manifest.audio = TRY(join_sound(options, whole.parts, folder.path(), stop));
  JoinedPackages joined;
  joined.frames = static_cast<std::uint32_t>(shown_frames(manifest).size());
  joined.segments = static_cast<std::uint32_t>(manifest.segments.size());
  joined.audio = manifest.audio;
  for (std::size_t i = 0; manifest.audio && i < whole.parts.size(); ++i)
    if (!whole.parts[i].audio) joined.silent.push_back(i);
  joined.bytes = TRY(write_package_manifest(folder.path(), manifest, options.output));
  for (const PackageFile* file : manifest.files()) joined.bytes += file->bytes;
  TRY(folder.publish());
  return joined;
}

}  // namespace pointreel
