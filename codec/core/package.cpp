#include "pointreel/package.h"

#include <algorithm>

namespace pointreel {

std::uint32_t Manifest::frame_count() const {
  return segments.empty() ? 0 : segments.back().first_frame + segments.back().frame_count();
}

std::vector<const PackageFile*> Segment::files() const {
  std::vector<const PackageFile*> files;
  for (const LayerFile& layer : layers) files.push_back(&layer);
  if (sound) files.push_back(&*sound);
  return files;
}

std::vector<const PackageFile*> Manifest::files() const {
  std::vector<const PackageFile*> files;
  if (tables) files.push_back(&*tables);
  if (audio) files.push_back(&*audio);
  for (const Segment& segment : segments) {
    for (const PackageFile* file : segment.files()) files.push_back(file);
  }
  return files;
}

FrameLocation locate(const Manifest& manifest, std::uint32_t frame) {
  const auto after =
      std::upper_bound(manifest.segments.begin(), manifest.segments.end(), frame,
                       [](std::uint32_t f, const Segment& s) { return f < s.first_frame; });
  const auto segment = static_cast<std::uint32_t>(after - manifest.segments.begin()) - 1;
  return {segment, frame - manifest.segments[segment].first_frame};
}

FrameGroup group_of(const Manifest& manifest, std::uint32_t frame) {
  if (manifest.group_frames == 0) return {frame, 1};
  const FrameLocation place = locate(manifest, frame);
  const std::uint32_t before = place.index % manifest.group_frames;
  const std::uint32_t left = manifest.segments[place.segment].frame_count() - place.index;
  return {frame - before, std::min(manifest.group_frames, before + left)};
}

ByteRange byte_range(const LayerFile& file, std::uint32_t index) {
  ByteRange range;
  for (std::uint32_t i = 0; i < index; ++i) range.offset += total(file.frames[i]);
  range.size = total(file.frames[index]);
  return range;
}

std::uint64_t frame_time_us(const Manifest& manifest, std::uint32_t frame) {
  const FrameLocation at = locate(manifest, frame);
  return manifest.segments[at.segment].times_us[at.index];
}

std::vector<std::uint32_t> shown_frames(const Manifest& manifest) {
  std::vector<std::uint32_t> shown;
  const std::uint32_t frames = manifest.frame_count();
  const auto end_of = [&](std::uint32_t frame) {
    return frame + 1 < frames ? frame_time_us(manifest, frame + 1) : manifest.duration_us;
  };
  for (std::uint32_t frame = 0; frame < frames; ++frame)
    if (manifest.group_frames == 0 || end_of(frame) > frame_time_us(manifest, frame))
      shown.push_back(frame);
  return shown;
}

std::uint32_t frame_at(const Manifest& manifest, std::uint64_t time_us) {
  const auto after =
      std::upper_bound(manifest.segments.begin(), manifest.segments.end(), time_us,
                       [](std::uint64_t t, const Segment& s) { return t < s.times_us.front(); });
  if (after == manifest.segments.begin()) return 0;
  const Segment& segment = *std::prev(after);
  const auto next = std::upper_bound(segment.times_us.begin(), segment.times_us.end(), time_us);
  return segment.first_frame + static_cast<std::uint32_t>(next - segment.times_us.begin()) - 1;
}

}  // namespace pointreel
