#include "server/edit/cut_package.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "codec/audio/audio_time.h"
#include "codec/package/package_folder.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/file_system/output_folder.h"
#include "server/edit/put_segment.h"
#include "server/edit/splice_sound.h"

namespace pointreel {
namespace {

/// To a millisecond.
std::string seconds_text(std::uint64_t us) {
  return number_text(1e-3 * std::round(1e-3 * static_cast<double>(us)), 12);
}

/// `shown`: the frames of the package that are shown.
Result<CutRange> frames_of(const CutOptions& options, const Manifest& manifest,
                           const std::vector<std::uint32_t>& shown) {
  if (shown.empty()) return fail(ErrorCode::argument, "has no frames");
  if (options.frames) {
    if (options.frames->last >= shown.size()) {
      return fail(ErrorCode::argument, fmt::format("has no frame {}, only frames 0 to {}",
                                                   options.frames->last, shown.size() - 1));
    }
    return *options.frames;
  }
  if (options.from_us >= manifest.duration_us && options.from_us > 0) {
    return fail(ErrorCode::argument,
                fmt::format("ends at {} s, before --from {}", seconds_text(manifest.duration_us),
                            seconds_text(options.from_us)));
  }
  const auto number_at = [&](std::uint64_t us) {
    const auto found = std::lower_bound(shown.begin(), shown.end(), frame_at(manifest, us));
    const auto last = std::ssize(shown) - 1;
    return static_cast<std::uint32_t>(std::min(found - shown.begin(), last));
  };
  return CutRange{number_at(options.from_us), number_at(options.to_us - 1)};
}

/// The share of what was done to all frames that falls to some of them.
void share(std::optional<Cleaning>& cleaning, std::uint32_t some, std::uint32_t all) {
  if (!cleaning || some == all) return;
  const double part = static_cast<double>(some) / all;
  cleaning->frames = static_cast<std::uint32_t>(std::lround(cleaning->frames * part));
  cleaning->removed =
      static_cast<std::uint64_t>(std::llround(static_cast<double>(cleaning->removed) * part));
  if (cleaning->frames == 0) cleaning.reset();
}

/// What is kept of the old package.
struct Cut {
  FrameLocation first, last;
  std::uint64_t begin_us = 0, end_us = 0;

  /// The frames of a segment that are kept, by their indices.
  std::uint32_t begin(std::uint32_t segment) const {
    return segment == first.segment ? first.index : 0;
  }
  std::uint32_t end(std::uint32_t segment, const Segment& whole) const {
    return segment == last.segment ? last.index + 1 : whole.frame_count();
  }
};

/// `first` and `last`: among all frames of the package.
Cut cut_at(const CutOptions& options, const Manifest& manifest, std::uint32_t first,
           std::uint32_t last) {
  // Video needs the frames before in its group, which are over when the first wanted one begins.
  Cut cut{locate(manifest, group_of(manifest, first).first), locate(manifest, last),
          options.from_us, std::min(options.to_us, manifest.duration_us)};
  if (!options.frames) return cut;
  if (first > 0) cut.begin_us = frame_time_us(manifest, first);
  if (last + 1 < manifest.frame_count()) cut.end_us = frame_time_us(manifest, last + 1);
  return cut;
}

template <class T>
void keep_part(std::vector<T>& all, std::uint32_t begin, std::uint32_t end) {
  all.erase(all.begin() + end, all.end());
  all.erase(all.begin(), all.begin() + begin);
}

/// The manifest of what is kept. Files have the names that they have in the old package.
Manifest keep(const Manifest& manifest, const Cut& cut) {
  Manifest kept = manifest;
  kept.live.reset();
  kept.audio.reset();
  kept.duration_us = cut.end_us - cut.begin_us;
  if (kept.captured_us) *kept.captured_us += cut.begin_us;
  kept.segments.clear();
  std::uint32_t frames = 0;
  for (std::uint32_t i = cut.first.segment; i <= cut.last.segment; ++i) {
    Segment& segment = kept.segments.emplace_back(manifest.segments[i]);
    const std::uint32_t begin = cut.begin(i), end = cut.end(i, manifest.segments[i]);
    keep_part(segment.times_us, begin, end);
    keep_part(segment.points, begin, end);
    for (LayerFile& file : segment.layers) keep_part(file.frames, begin, end);
    segment.first_frame = std::exchange(frames, frames + segment.frame_count());
    // The first frame may have been shown before.
    for (std::uint64_t& time : segment.times_us) time = std::max(time, cut.begin_us) - cut.begin_us;
  }
  const bool any_point = std::ranges::any_of(kept.segments, [](const Segment& segment) {
    return std::ranges::any_of(segment.points, [](std::uint32_t points) { return points > 0; });
  });
  if (!any_point) kept.bounds = {};
  share(kept.cleaning, kept.frame_count(), manifest.frame_count());
  // It may be that of frames that are left out.
  if (kept.frame_count() != manifest.frame_count()) kept.coding_error.reset();
  return kept;
}

Result<std::optional<AudioFile>> cut_sound(const CutOptions& options, const AudioFile& audio,
                                           const Cut& cut, const std::filesystem::path& folder,
                                           const std::stop_token& stop) {
  const std::uint64_t first = first_sample_from(cut.begin_us), end = first_sample_from(cut.end_us);
  if (first >= std::min(end, audio.samples)) return std::nullopt;
  const std::array piece{SoundPiece{TRY(options.input.local(audio)), options.input.shown(audio),
                                    audio.bytes, first, 0, end - first}};
  return splice_sound(piece, folder, stop);
}

}  // namespace

Result<CutReport> cut_package(const CutOptions& options, const std::stop_token& stop) {
  const Manifest manifest = TRY(options.input.manifest());
  const std::vector<std::uint32_t> shown = shown_frames(manifest);
  const CutRange frames = TRY(at_place(options.input.shown(), frames_of(options, manifest, shown)));
  const Cut cut = cut_at(options, manifest, shown[frames.first], shown[frames.last]);
  Manifest kept = keep(manifest, cut);
  kept.name = reel_name(options.name, options.output);
  if (kept.duration_us == 0) {
    return fail(ErrorCode::argument,
                fmt::format("{}: frames {} are shown for no time", options.input.shown(),
                            span_text(frames.first, frames.last)));
  }
  OutputFolder folder = TRY(OutputFolder::create(
      options.output, options.force ? may_replace_package : OutputFolder::MayReplace{}));
  for (std::uint32_t i = cut.first.segment; i <= cut.last.segment; ++i) {
    if (stop.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);
    const Segment& whole = manifest.segments[i];
    Segment& segment = kept.segments[i - cut.first.segment];
    TRY(segment.frame_count() == whole.frame_count()
            ? put_segment(options.input, folder.path(), kept.layer_names, segment)
            : put_frames(options.input, folder.path(), kept.layer_names, whole, cut.begin(i),
                         segment));
  }
  if (kept.tables) TRY(put_file(options.input, *kept.tables, folder.path(), kept.tables->path));
  if (manifest.audio)
    kept.audio = TRY(cut_sound(options, *manifest.audio, cut, folder.path(), stop));
  CutReport report;
  report.frames = frames;
  report.segments = cut.last.segment - cut.first.segment + 1;
  report.audio = kept.audio;
  report.bytes = TRY(write_package_manifest(folder.path(), kept, options.output));
  for (const PackageFile* file : kept.files()) report.bytes += file->bytes;
  TRY(folder.publish());
  return report;
}

}  // namespace pointreel
