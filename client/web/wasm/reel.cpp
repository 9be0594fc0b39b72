#include "client/web/wasm/reel.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "client/source/fetched.h"
#include "client/web/wasm/camera.h"
#include "client/web/wasm/errors.h"

using namespace pointreel;

namespace {

std::string reel_text;  // of the last pr_reel_text
std::vector<PrRange> ranges;
PrSegment segment;

/// As reel.json writes checksums and sessions.
std::string hex(std::uint64_t value) {
  std::string digits(16, '0');
  for (auto digit = digits.rbegin(); digit != digits.rend(); ++digit, value >>= 4)
    *digit = "0123456789abcdef"[value & 15];
  return digits;
}

void copy(const glm::dvec3& from, double* to) {
  for (int i = 0; i < 3; ++i) to[i] = from[i];
}

double number_of_codec(const std::string& name) {
  return name == "octree" ? 1 : name == "draco" ? 2 : 3;
}

}  // namespace

PrReel pointreel::reel_of(Manifest manifest) {
  PrReel reel;
  PrReelInfo& info = reel.info;
  info.frames = manifest.frame_count();
  info.duration_us = static_cast<double>(manifest.duration_us);
  info.fps = manifest.fps;
  info.codec = number_of_codec(manifest.codec);
  info.layers = static_cast<double>(std::max<std::size_t>(1, manifest.layer_names.size()));
  info.segments = static_cast<double>(manifest.segments.size());
  info.depth_min = manifest.depth_min;
  info.depth_max = manifest.depth_max;
  info.up = number_of(manifest.up);
  info.colors = manifest.colors;
  info.normals = manifest.normals;
  info.partial = manifest.partial;
  info.normals_estimated = manifest.normals_estimated;
  copy(manifest.bounds.min, info.bounds_min);
  copy(manifest.bounds.max, info.bounds_max);
  info.max_error = manifest.max_error.value_or(-1.0);
  info.tables_bytes = manifest.tables ? static_cast<double>(manifest.tables->bytes) : 0.0;
  info.scalars = static_cast<double>(manifest.scalars.size());
  info.group_frames = manifest.group_frames;
  info.audio_bytes = manifest.audio ? static_cast<double>(manifest.audio->bytes) : 0.0;
  if (manifest.live) {
    info.live = 1;
    info.live_first_frame = manifest.live->first_frame;
    info.live_start_us = static_cast<double>(manifest.live->start_us);
    info.live_ended = manifest.live->ended;
  }
  for (const Segment& part : manifest.segments)
    for (const std::uint64_t time : part.times_us) reel.times.push_back(static_cast<double>(time));
  reel.manifest = std::move(manifest);
  return reel;
}

PrReel* pr_reel_new(const char* bytes, std::uint32_t size) {
  auto manifest = parse_manifest({bytes, size});
  if (manifest) return new PrReel(reel_of(*std::move(manifest)));
  report(manifest.error());
  return nullptr;
}

void pr_reel_free(PrReel* reel) { delete reel; }
const PrReelInfo* pr_reel_info(const PrReel* reel) { return &reel->info; }
const double* pr_reel_times(const PrReel* reel) { return reel->times.data(); }

const char* pr_reel_text(const PrReel* reel, PrText which, std::uint32_t index) {
  const Manifest& manifest = reel->manifest;
  reel_text.clear();
  switch (which) {
    case PR_TEXT_NAME:
      reel_text = manifest.name;
      break;
    case PR_TEXT_CODEC:
      reel_text = manifest.codec;
      break;
    case PR_TEXT_ENTROPY:
      reel_text = manifest.entropy;
      break;
    case PR_TEXT_LAYER:
      if (index < manifest.layer_names.size()) reel_text = manifest.layer_names[index];
      break;
    case PR_TEXT_TABLES_PATH:
      if (manifest.tables) reel_text = manifest.tables->path;
      break;
    case PR_TEXT_TABLES_CHECKSUM:
      if (manifest.tables) reel_text = hex(manifest.tables->checksum);
      break;
    case PR_TEXT_SESSION:
      if (manifest.live) reel_text = hex(manifest.live->session);
      break;
    case PR_TEXT_AUDIO_PATH:
      if (manifest.audio) reel_text = manifest.audio->path;
      break;
    case PR_TEXT_SCALAR:
      if (index < manifest.scalars.size()) reel_text = manifest.scalars[index].name;
      break;
  }
  return reel_text.c_str();
}

const PrScalarRange* pr_reel_scalar(const PrReel* reel, std::uint32_t index) {
  static PrScalarRange answer;
  const ScalarRange& range = reel->manifest.scalars[index];
  answer = {range.least, range.most, range.labels ? 1.0 : 0.0};
  return &answer;
}

const PrSegment* pr_reel_segment(const PrReel* reel, std::uint32_t frame) {
  const std::uint32_t number = locate(reel->manifest, frame).segment;
  const Segment& part = reel->manifest.segments[number];
  segment.number = number;
  segment.first_frame = part.first_frame;
  segment.frames = part.frame_count();
  copy(part.cube.origin, segment.cube_origin);
  segment.cube_edge = part.cube.edge;
  return &segment;
}

const PrGroup* pr_reel_group(const PrReel* reel, std::uint32_t frame) {
  static PrGroup group;
  const FrameGroup found = group_of(reel->manifest, frame);
  group = {static_cast<double>(found.first), static_cast<double>(found.frames)};
  return &group;
}

const char* pr_reel_file(const PrReel* reel, std::uint32_t number, std::uint32_t layer) {
  return reel->manifest.segments[number].layers[layer].path.c_str();
}

double pr_reel_file_bytes(const PrReel* reel, std::uint32_t number, std::uint32_t layer) {
  return static_cast<double>(reel->manifest.segments[number].layers[layer].bytes);
}

const PrRange* pr_reel_ranges(const PrReel* reel, std::uint32_t frame, const PrLayers* layers) {
  ranges.clear();
  const auto wanted =
      ranges_of(reel->manifest, frame,
                {layers->first, layers->end, layers->colors != 0, layers->normals != 0});
  if (!wanted) {
    report(wanted.error());
    return nullptr;
  }
  double layer = layers->first;
  const std::uint32_t index = locate(reel->manifest, frame).index;
  for (const FileRange& range : *wanted) {
    const std::uint64_t offset = byte_range(*range.file, index).offset;
    ranges.push_back(
        {layer++, static_cast<double>(offset), static_cast<double>(range.sizes.geometry),
         static_cast<double>(range.sizes.colors), static_cast<double>(range.sizes.normals)});
  }
  return ranges.data();
}

std::uint32_t pr_reel_range_count() { return static_cast<std::uint32_t>(ranges.size()); }
