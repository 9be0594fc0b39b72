#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "codec/package/manifest.h"
#include "pointreel/package.h"
#include "tests/fuzz/target.h"

/// An accepted manifest must satisfy what the parser guarantees: every frame can be located, its
/// bytes are inside their files, and writing and parsing the manifest again changes nothing.
FUZZ_TARGET(reel, .longest = 1 << 20, .repeats = true) {
  const auto manifest = parse_manifest(as_text(input));
  if (!manifest) {
    if (manifest.error().message.empty()) std::abort();
    return;
  }
  if (manifest->tables &&
      (manifest->entropy != "context" || manifest->tables->bytes > kMaxTablesBytes)) {
    std::abort();
  }
  if (manifest->audio &&
      (manifest->audio->samples == 0 || manifest->audio->bytes > kMaxAudioBytes)) {
    std::abort();
  }
  std::uint64_t last_time = 0;
  for (std::uint32_t frame = 0; frame < manifest->frame_count(); ++frame) {
    const FrameLocation at = locate(*manifest, frame);
    const Segment& segment = manifest->segments.at(at.segment);
    if (segment.layers.size() != manifest->layer_names.size()) std::abort();
    for (const LayerFile& file : segment.layers) {
      const ByteRange range = byte_range(file, at.index);
      if (range.offset + range.size > file.bytes) std::abort();
    }
    const std::uint64_t time = frame_time_us(*manifest, frame);
    if (time < last_time || time > manifest->duration_us) std::abort();
    if (frame_time_us(*manifest, frame_at(*manifest, time)) != time) std::abort();
    last_time = time;
  }
  const std::string text = write_manifest(*manifest);
  const auto again = parse_manifest(text);
  if (!again || write_manifest(*again) != text) std::abort();
}
