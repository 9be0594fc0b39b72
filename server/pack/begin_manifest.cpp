#include "server/pack/begin_manifest.h"

#include <algorithm>

#include "codec/core/scalar_fields.h"
#include "codec/package/encoding_options.h"
#include "codec/package/segment_writer.h"
#include "pointreel/codec.h"

namespace pointreel {

bool has_times_of_files(const PackOptions& options, const CloudSequence& sequence) {
  return options.times_of_files && !sequence.times_us.empty();
}

Manifest begin_manifest(PackOptions& options, const CloudSequence& sequence) {
  const bool timed = has_times_of_files(options, sequence);
  if (timed && !options.keep_gaps) options.fps = std::clamp(sequence.fps, kMinFps, kMaxFps);
  Manifest manifest;
  static_cast<ReelHead&>(manifest) = reel_head(options);
  if (options.video) {
    manifest.codec = name(Codec::video);
    manifest.layer_names = {"base", "video"};
    manifest.group_frames = options.video->group_frames;
  } else if (options.encode.id() == Codec::octree)
    add_scalar_layer(manifest.layer_names);
  manifest.duration_us =
      timed ? sequence.end_us() : presentation_time_us(sequence.frames.size(), options.fps);
  if (timed) manifest.captured_us = sequence.captured_us();
  return manifest;
}

}  // namespace pointreel
