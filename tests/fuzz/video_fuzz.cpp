#include <algorithm>
#include <cstdlib>
#include <optional>

#include "codec/video/video_decoder.h"
#include "common/base/byte_io.h"
#include "pointreel/codec.h"
#include "tests/fuzz/target.h"

namespace pointreel::fuzz::video {

/// Takes a length and so many bytes, or all that are left, from the front.
Bytes take(ByteView& bytes) {
  ByteReader reader(bytes);
  const std::size_t wanted = reader.get<std::uint32_t>();
  const ByteView taken = reader.rest().first(std::min(wanted, reader.rest().size()));
  bytes = reader.rest().subspan(taken.size());
  return Bytes(taken.begin(), taken.end());
}

}  // namespace pointreel::fuzz::video

/// Frames of a group, as they are in the input but with correct checksums, give points that fit
/// together, or errors of one line.
FUZZ_TARGET(video, .longest = 1 << 15) {
  namespace video = pointreel::fuzz::video;
  DecodeLimits limits;
  limits.max_points = 1u << 18;
  limits.max_memory = 64u << 20;
  VideoDecoder decoder;
  ByteView rest = input;
  for (int index = 0; index < 4 && !rest.empty(); ++index) {
    VideoGeometry geometry;
    for (Bytes* part : {&geometry.group, &geometry.occupancy, &geometry.leftovers, &geometry.depth})
      *part = video::take(rest);
    const Chunks<Bytes> chunks = video_chunks(index, geometry, video::take(rest));
    const auto pictures = decoder.next({chunks.geometry, chunks.colors, {}}, limits);
    if (!pictures) {
      require(one_line(pictures.error().message));
      return;
    }
    const auto points = points_of(*pictures, limits);
    if (!points) {
      require(one_line(points.error().message));
      return;
    }
    require(points->normals.size() == points->size());
    require(points->colors.empty() || points->colors.size() == points->size());
    DecodeLimits coarse = limits;
    coarse.spacing = 4.0 * pictures->group->pitch;
    const auto frame = frame_of(*pictures, coarse);
    require(frame && frame->cloud.size() <= points->size());
    require(frame->cloud.radii.size() == frame->cloud.size());
  }
}
