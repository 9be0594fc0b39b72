#include "server/pack/begin_manifest.h"

#include <algorithm>

#include "codec/package/segment_writer.h"
#include "codec/segments/pack_segment.h"

namespace pointreel {

bool has_times_of_files(const PackOptions& options, const CloudSequence& sequence) {
  return options.times_of_files && !sequence.times_us.empty();
}

Manifest begin_manifest(PackOptions& options, const CloudSequence& sequence) {
  const bool timed = has_times_of_files(options, sequence);
  if (timed && !options.keep_gaps) options.fps = std::clamp(sequence.fps, kMinFps, kMaxFps);
  Manifest manifest;
  static_cast<ReelHead&>(manifest) = head_of(options);
  manifest.duration_us =
      timed ? sequence.end_us() : presentation_time_us(sequence.frames.size(), options.fps);
  if (timed) manifest.captured_us = sequence.captured_us();
  return manifest;
}

}  // namespace pointreel
