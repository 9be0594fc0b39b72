#include "server/pack/segment_packer.h"

#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "common/base/try.h"
#include "common/file_system/output_folder.h"
#include "server/pack/input.h"
#include "server/pack/trials.h"
#include "server/rate/rate_control.h"

namespace pointreel {

Result<PackedSegment> SegmentPacker::pack(std::span<const CloudFrame> files,
                                          std::uint32_t first_frame) {
  SegmentInput input(files, options_);
  const Result<void> found = input.find_shared_grid(output_.stop);
  if (output_.stop.stop_requested()) return fail(ErrorCode::cancelled, kInterrupted);
  TRY(found);
  return options_.bitrate ? pack_within_rate(input, first_frame)
                          : pack_segment(input, first_frame, options_, limits_, output_);
}

/// Finds the finest options that meet the bit rate, and packs the segment with them.
Result<PackedSegment> SegmentPacker::pack_within_rate(SegmentInput& input,
                                                      std::uint32_t first_frame) {
  const Trials trials = TRY(Trials::create(input));
  const double seconds = static_cast<double>(input.size()) / options_.fps;
  const double budget = *options_.bitrate / 8.0 * seconds;
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
      for (const LayerFile& file : packed.entry.layers) {
        std::error_code ignored;
        std::filesystem::remove(output_.folder / file.path, ignored);
      }
      output.frame_done = {};  // each frame counts once
      continue;
    }
    packed.summary.trials = control.trials();
    packed.summary.within_rate = bytes <= budget;
    if (!packed.summary.within_rate) {
      const std::string excess = fmt::format(
          "frames {} to {} take {:.3g} Mbit/s at the coarsest, more than the bit rate", first_frame,
          first_frame + input.size() - 1, 1e-6 * packed.summary.bits_per_second);
      if (!options_.best_effort) {
        return fail(ErrorCode::limit, excess +
                                          ": give a higher --bitrate, or --best-effort to pack "
                                          "them nevertheless");
      }
      packed.warnings.push_back(excess);
    }
    return packed;
  }
}

}  // namespace pointreel
