#include "codec/video/video_group.h"

#include <cmath>
#include <cstddef>

#include "codec/octree/frame_header.h"
#include "common/base/byte_io.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

constexpr std::uint8_t kGroupVersion = 1;
constexpr std::size_t kMostPatches = static_cast<std::size_t>(kViews) * kViewLayers;

std::uint16_t in_grains(int pixels) { return static_cast<std::uint16_t>(pixels / kPatchGrain); }
int in_pixels(std::uint16_t grains) { return kPatchGrain * grains; }

Result<void> check_patch(const VideoGroup& group, const Patch& patch) {
  const bool fits =
      patch.view < kViews && patch.layer < kViewLayers && patch.width > 0 && patch.height > 0 &&
      patch.x + patch.width <= kLargestAtlas && patch.y + patch.height <= kLargestAtlas &&
      patch.atlas_x + patch.width <= group.width && patch.atlas_y + patch.height <= group.height;
  if (!fits) return fail("a patch of the video does not fit into its picture");
  return {};
}

bool overlap(const Patch& a, const Patch& b) {
  return a.atlas_x < b.atlas_x + b.width && b.atlas_x < a.atlas_x + a.width &&
         a.atlas_y < b.atlas_y + b.height && b.atlas_y < a.atlas_y + a.height;
}

}  // namespace

void write_video_group(const VideoGroup& group, Bytes& out) {
  ByteWriter writer(out);
  writer.put(kGroupVersion);
  writer.put<std::uint8_t>(group.colors ? 1 : 0);
  writer.put(static_cast<std::uint16_t>(group.frames));
  for (int axis = 0; axis < 3; ++axis) writer.put(group.origin[axis]);
  writer.put(group.pitch);
  writer.put(in_grains(group.width));
  writer.put(in_grains(group.height));
  for (const DepthSteps& depth : group.depth) {
    writer.put(depth.begin);
    writer.put(depth.steps);
  }
  writer.put(static_cast<std::uint8_t>(group.patches.size()));
  for (const Patch& patch : group.patches) {
    writer.put(static_cast<std::uint8_t>(patch.view));
    writer.put(static_cast<std::uint8_t>(patch.layer));
    for (const int pixels :
         {patch.x, patch.y, patch.width, patch.height, patch.atlas_x, patch.atlas_y})
      writer.put(in_grains(pixels));
  }
}

Result<ParsedVideoGroup> read_video_group(ByteView bytes) {
  ByteReader reader(bytes);
  const auto version = reader.get<std::uint8_t>();
  if (version != kGroupVersion)
    return fail(ErrorCode::unsupported, "the video is of another version");
  ParsedVideoGroup parsed;
  VideoGroup& group = parsed.group;
  const auto colors = reader.get<std::uint8_t>();
  group.colors = colors != 0;
  group.frames = reader.get<std::uint16_t>();
  for (int axis = 0; axis < 3; ++axis) group.origin[axis] = reader.get<double>();
  group.pitch = reader.get<double>();
  group.width = in_pixels(reader.get<std::uint16_t>());
  group.height = in_pixels(reader.get<std::uint16_t>());
  for (DepthSteps& depth : group.depth) {
    depth.begin = reader.get<float>();
    depth.steps = reader.get<float>();
  }
  const std::size_t count = reader.get<std::uint8_t>();
  if (!reader.ok() || colors > 1 || count > kMostPatches || group.frames < 1 ||
      group.frames > kMostGroupFrames)
    return fail("the video's header is damaged");
  if (group.width > kLargestAtlas || group.height > kLargestAtlas)
    return fail("the video's pictures are too large");
  // dav1d takes a limit of 0 pixels for none.
  if (group.width == 0 || group.height == 0) return fail("the video's pictures are empty");
  if (!is_codable({group.origin, group.pitch})) return fail("the video's pixels have no size");
  for (const DepthSteps& depth : group.depth) {
    if (!std::isfinite(depth.begin) || std::abs(depth.begin) > 2.0f * kLargestAtlas ||
        !(depth.steps > 1e-3f && depth.steps < 1e3f))
      return fail("the video's depth has no steps");
  }
  for (std::size_t i = 0; i < count; ++i) {
    Patch patch;
    patch.view = reader.get<std::uint8_t>();
    patch.layer = reader.get<std::uint8_t>();
    for (int* pixels :
         {&patch.x, &patch.y, &patch.width, &patch.height, &patch.atlas_x, &patch.atlas_y})
      *pixels = in_pixels(reader.get<std::uint16_t>());
    TRY(check_patch(group, patch));
    for (const Patch& other : group.patches)
      if (overlap(patch, other)) return fail("patches of the video overlap");
    group.patches.push_back(patch);
  }
  if (!reader.ok()) return fail("the video's header ends early");
  parsed.rest = reader.rest();
  return parsed;
}

}  // namespace pointreel
