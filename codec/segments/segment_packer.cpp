#include "codec/segments/segment_packer.h"

#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "codec/rate/quality_search.h"
#include "codec/rate/rate_control.h"
#include "codec/segments/input.h"
#include "codec/segments/trials.h"
#include "common/base/try.h"
#include "common/file_system/output_folder.h"

namespace pointreel {
namespace {

void begin_anew(SegmentOutput& output, const PackedSegment& packed) {
  for (const LayerFile& file : packed.entry.layers) {
    std::error_code ignored;
    std::filesystem::remove(output.folder / file.path, ignored);
  }
  output.frame_done = {};  // each frame counts once
}

}  // namespace

Result<PackedSegment> SegmentPacker::pack(std::uint32_t first_frame, std::size_t count) {
  SegmentInput input(frames_, first_frame, count, options_);
  return pack(input, first_frame);
}

Result<PackedSegment> SegmentPacker::pack(std::uint32_t first_frame,
                                          std::vector<LoadedCloud> clouds) {
  std::vector<Result<SegmentInput::Cloud>> made(clouds.size());
  tbb::parallel_for(std::size_t{0}, clouds.size(), [&](std::size_t i) {
    made[i] = source_frame(std::move(clouds[i]), fmt::format("frame {}", first_frame + i), options_)
                  .map([&](SourceFrame&& frame) -> SegmentInput::Cloud {
                    add_missing_normals(frame, options_);
                    return std::make_shared<const SourceFrame>(std::move(frame));
                  });
  });
  std::vector<SegmentInput::Cloud> frames;
  for (Result<SegmentInput::Cloud>& frame : made) frames.push_back(TRY(std::move(frame)));
  SegmentInput input(std::move(frames), first_frame, options_);
  return pack(input, first_frame);
}

Result<PackedSegment> SegmentPacker::pack(SegmentInput& input, std::uint32_t first_frame) {
  const Result<void> found = input.find_shared_grid(output_.stop);
  if (output_.stop.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);
  TRY(found);
  if (!options_.bitrate) return pack_segment(input, first_frame, options_, limits_, output_);
  PackedSegment packed = TRY(options_.video ? pack_video_within_rate(input, first_frame)
                                            : pack_within_rate(input, first_frame));
  if (packed.summary.within_rate) return packed;
  const std::string excess = fmt::format(
      "frames {} to {} take {:.3g} Mbit/s at the coarsest, more than the bit rate", first_frame,
      first_frame + input.size() - 1, 1e-6 * packed.summary.bits_per_second);
  if (!options_.best_effort) {
    return fail(ErrorCode::limit,
                excess + ": give a higher --bitrate, or --best-effort to pack them nevertheless");
  }
  packed.warnings.push_back(excess);
  return packed;
}

double SegmentPacker::budget(std::size_t frames) const {
  return *options_.bitrate / 8.0 * static_cast<double>(frames) / options_.fps;
}

/// Finds the finest options that meet the bit rate, and packs the segment with them.
Result<PackedSegment> SegmentPacker::pack_within_rate(SegmentInput& input,
                                                      std::uint32_t first_frame) {
  const Trials trials = TRY(Trials::create(input));
  const double budget = this->budget(input.size());
  RateControl control(budget, trials.have_attributes(options_.encode));
  SegmentOutput output = output_;
  for (;;) {
    const Result<void> tried = trials.run(control, output_.stop);
    if (output_.stop.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);
    TRY(tried);
    limits_.begin_segment(control.finest(), control.choice());
    PackedSegment packed = TRY(pack_segment(input, first_frame, options_, limits_, output));
    const auto bytes = static_cast<double>(packed.summary.bytes);
    // The trials encode only some of the frames. If all together take more, it starts again.
    if (bytes > budget && control.overshot(bytes)) {
      begin_anew(output, packed);
      continue;
    }
    packed.summary.trials = control.trials();
    packed.summary.within_rate = bytes <= budget;
    return packed;
  }
}

Result<PackedSegment> SegmentPacker::pack_video_within_rate(SegmentInput& input,
                                                            std::uint32_t first_frame) {
  PackOptions options = options_;
  SegmentOutput output = output_;
  const SegmentInput::Cloud middle = TRY(input.look(input.size() / 2));
  QualitySearch search(budget(input.size()), options.video->quality,
                       middle->cloud.size() * input.size());
  for (;;) {
    options.video->quality = search.quality();
    PackedSegment packed = TRY(pack_segment(input, first_frame, options, limits_, output));
    if (search.accepts(static_cast<double>(packed.summary.bytes))) {
      packed.summary.trials = search.tries();
      packed.summary.video_quality = options.video->quality;
      packed.summary.within_rate = search.fits();
      return packed;
    }
    begin_anew(output, packed);
  }
}

}  // namespace pointreel
