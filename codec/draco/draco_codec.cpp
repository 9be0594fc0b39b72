#include "codec/draco/draco_codec.h"

#include <algorithm>
#include <array>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "codec/draco/draco_payload.h"
#include "codec/octree/frame_header.h"
#include "common/base/concat.h"
#include "common/base/try.h"
#include "pointreel/chunks.h"
#include "pointreel/draco.h"

namespace pointreel {
namespace {

FrameTag tag_of(ByteView payload, const Cube& cube) {
  const std::array<double, 4> place = {cube.origin.x, cube.origin.y, cube.origin.z, cube.edge};
  return static_cast<FrameTag>(XXH3_64bits_withSeed(payload.data(), payload.size(),
                                                    XXH3_64bits(place.data(), sizeof(place))));
}

}  // namespace

Result<EncodedFrame> encode_draco(const PointCloud& cloud, const Cube& cube,
                                  const DracoOptions& options, bool normals, bool colors) {
  const Bytes payload = TRY(encode_draco_payload(cloud, cube, options, normals, colors));

  FrameHeader header;
  header.codec = Codec::draco;
  header.depth = static_cast<std::uint8_t>(options.position_bits);
  header.has_colors = colors && cloud.has_colors();
  header.has_normals = normals && cloud.has_normals();
  header.colors_16_bit = header.has_colors && !colors_fit_8_bits(cloud);
  header.source_points = header.coded_points = static_cast<std::uint32_t>(cloud.size());
  header.cube = cube;

  EncodedFrame frame;
  frame.source_points = frame.coded_points = header.coded_points;
  frame.depth = header.depth;
  Bytes& out = frame.layers.emplace_back().geometry;
  const FrameTag tag = tag_of(payload, cube);
  write_frame_header(header, tag, out);
  ChunkHeader chunk;
  chunk.raw_size = static_cast<std::uint32_t>(payload.size());
  write_chunk(chunk, tag, payload, out);
  return frame;
}

Result<DecodedFrame> decode_draco(const std::vector<Chunks<ByteView>>& layers,
                                  const DecodeLimits& limits) {
  if (layers.empty()) return fail(ErrorCode::argument, "a frame needs at least its base layer");
  const ParsedFrameHeader parsed = TRY(read_frame_header(layers.front().geometry));
  const FrameHeader& header = parsed.header;
  if (header.codec != Codec::draco) return fail("not a Draco frame");
  if (header.layers != 1 || header.depth < 1 || header.coded_points != header.source_points ||
      (header.colors_16_bit && !header.has_colors)) {
    return fail("frame header has a field out of range");
  }
  if (header.coded_points > limits.max_points) {
    return fail(ErrorCode::limit, concat("frame has ", header.coded_points,
                                         " points, more than the ", limits.max_points, " allowed"));
  }
  const ParsedChunk chunk = TRY(read_chunk(parsed.rest, ChunkKind::geometry, 0, parsed.tag));
  if (chunk.header.entropy != Entropy::none || chunk.header.last_level != 0 ||
      chunk.header.raw_size != chunk.payload.size()) {
    return fail("chunk header has a field out of range");
  }
  // Decodes at most as many points as the header has. The check below notices if there are fewer.
  DecodeLimits payload_limits = limits;
  payload_limits.max_points = header.coded_points;
  DecodedFrame frame;
  frame.cloud = TRY(decode_draco_payload(chunk.payload, header.cube, header.depth, payload_limits));
  const PointCloud& cloud = frame.cloud;
  if (cloud.size() != header.coded_points ||
      (!cloud.empty() &&
       (cloud.has_normals() != header.has_normals || cloud.has_colors() != header.has_colors))) {
    return fail("the Draco data disagree with the frame header on points or attributes");
  }
  frame.cube = header.cube;
  frame.source_points = header.source_points;
  return frame;
}

}  // namespace pointreel
