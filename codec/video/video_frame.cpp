#include "codec/video/video_frame.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "codec/octree/frame_header.h"
#include "codec/video/coarse_pictures.h"
#include "codec/video/picture_points.h"
#include "codec/video/pixel_depths.h"
#include "common/base/byte_io.h"
#include "common/base/concat.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// Of a pixel, at most: its mask and depths, and eight reference pictures of both videos.
constexpr std::uint64_t kBytesOfPixel = 64;
/// Of a point, at most: what a cloud holds of it, and what is made of that for drawing.
constexpr std::uint64_t kBytesOfPoint = 56;
/// The points of a block that is on, at most: rounding its edges adds corners of those beside it.
constexpr std::uint64_t kPointsOfBlock = kBlock * kBlock + 2;

struct Parts {
  ByteView group, occupancy, leftovers, depth;
};

Result<Parts> read_parts(ByteView payload) {
  ByteReader reader(payload);
  std::array<std::size_t, 3> sizes{};
  for (std::size_t& size : sizes) size = reader.get<std::uint32_t>();
  ByteView rest = reader.rest();
  Parts parts;
  std::size_t i = 0;
  for (ByteView* part : {&parts.group, &parts.occupancy, &parts.leftovers}) {
    if (!reader.ok() || sizes[i] > rest.size()) return fail("a frame of the video ends early");
    *part = rest.first(sizes[i]);
    rest = rest.subspan(sizes[i++]);
  }
  parts.depth = rest;
  return parts;
}

/// The layers of the octree of leftovers: sizes and bytes of geometry and colours.
Result<std::vector<Chunks<ByteView>>> leftover_layers(ByteView bytes) {
  std::vector<Chunks<ByteView>> layers;
  while (!bytes.empty()) {
    Chunks<ByteView>& layer = layers.emplace_back();
    for (ByteView* chunk : {&layer.geometry, &layer.colors}) {
      ByteReader reader(bytes);
      const std::size_t size = reader.get<std::uint32_t>();
      if (!reader.ok() || size > reader.rest().size())
        return fail("the leftovers of the video end early");
      *chunk = reader.rest().first(size);
      bytes = reader.rest().subspan(size);
    }
    if (layers.size() > 3) return fail("the leftovers of the video have too many layers");
  }
  return layers;
}

/// Fails if points are so far from the others that floats cannot tell where.
/// `radius`: of those.
Result<void> append(PointCloud& cloud, const PointCloud& more, const PointParts& parts,
                    double radius) {
  const glm::vec3 offset(more.origin - cloud.origin);
  const bool colors = cloud.has_colors() || (cloud.empty() && more.has_colors());
  for (const glm::vec3& position : more.positions) {
    const glm::vec3 moved = offset + position;
    if (!std::isfinite(glm::dot(moved, glm::vec3(1.0f))))
      return fail("points outside of the video's views are too far away");
    cloud.positions.push_back(moved);
  }
  if (colors) {
    if (more.has_colors())
      cloud.colors.insert(cloud.colors.end(), more.colors.begin(), more.colors.end());
    cloud.colors.resize(cloud.size());
  }
  if (parts.radii) cloud.radii.resize(cloud.size(), static_cast<float>(radius));
  if (parts.normals) {
    if (more.has_normals())
      cloud.normals.insert(cloud.normals.end(), more.normals.begin(), more.normals.end());
    cloud.normals.resize(cloud.size(), glm::vec3(0.0f));
  }
  return {};
}

/// How often pictures of this pitch can be halved until points are that far apart.
int halvings(double pitch, double spacing) {
  int count = 0;
  // Cells of a cube whose edge is a whole number of pixels, but for rounding.
  for (double next = 1.999 * pitch; next <= spacing && count < kMostHalvings; next *= 2.0) ++count;
  return count;
}

Result<PointCloud> decode_leftovers(const Bytes& leftovers, DecodeLimits limits) {
  if (leftovers.empty()) return PointCloud();
  limits.inner_nodes = false;
  limits.leaves = true;
  DecodedFrame frame = TRY(decode_octree(TRY(leftover_layers(leftovers)), limits));
  return std::move(frame.cloud);
}

Result<DecodedFrame> make_frame(const VideoPictures& pictures, const DecodeLimits& limits,
                                const PointParts& parts) {
  const VideoGroup* group = pictures.group.get();
  const Av1Picture* colors = pictures.colors ? &*pictures.colors : nullptr;
  PixelDepths depths = read_depths(*group, pictures.blocks, pictures.depth.depth, limits.executor);
  const PointCloud left = TRY(decode_leftovers(pictures.leftovers, limits));
  DecodedFrame frame;
  frame.spaced = true;
  frame.source_points = static_cast<std::uint32_t>(
      std::accumulate(depths.points.begin(), depths.points.end(), left.size()));
  CoarsePictures coarse;
  for (int i = halvings(group->pitch, limits.spacing); i > 0; --i) {
    coarse = halve(*group, depths, colors, limits.executor);
    group = &coarse.group;
    depths = std::move(coarse.depths);
    colors = coarse.colors ? &*coarse.colors : nullptr;
  }
  frame.cloud = points_of(*group, depths, colors, parts, left.size(), limits.executor);
  TRY(append(frame.cloud, left, parts, pictures.group->pitch));
  return frame;
}

Bytes payload_of(const VideoGeometry& geometry) {
  Bytes payload;
  ByteWriter writer(payload);
  for (const Bytes* part : {&geometry.group, &geometry.occupancy, &geometry.leftovers})
    writer.put(static_cast<std::uint32_t>(part->size()));
  for (const Bytes* part :
       {&geometry.group, &geometry.occupancy, &geometry.leftovers, &geometry.depth})
    payload.insert(payload.end(), part->begin(), part->end());
  return payload;
}

/// A chunk that video_chunks makes: its payload is as it is.
Result<ParsedChunk> read_video_chunk(ByteView bytes, ChunkKind kind, FrameTag tag) {
  const ParsedChunk chunk = TRY(read_chunk(bytes, kind, 1, tag));
  const ChunkHeader& header = chunk.header;
  if (header.entropy != Entropy::none || header.last_level != 0 ||
      header.raw_size != chunk.payload.size())
    return fail("the header of a chunk is not one of video");
  return chunk;
}

/// Frames of a group are told apart by their number.
Bytes chunk_of(ChunkKind kind, int index, const Bytes& payload) {
  Bytes chunk;
  ChunkHeader header;
  header.kind = kind;
  header.layer = 1;
  header.raw_size = static_cast<std::uint32_t>(payload.size());
  write_chunk(header, static_cast<FrameTag>(index), payload, chunk);
  return chunk;
}

}  // namespace

Chunks<Bytes> video_chunks(int index, const VideoGeometry& geometry, const Bytes& colors) {
  Chunks<Bytes> chunks;
  chunks.geometry = chunk_of(ChunkKind::geometry, index, payload_of(geometry));
  if (!colors.empty()) chunks.colors = chunk_of(ChunkKind::colors, index, colors);
  return chunks;
}

namespace {

tl::unexpected<Error> too_large(const VideoGroup& group) {
  return fail(ErrorCode::limit, concat("the video's pictures of ", group.width, " x ", group.height,
                                       " pixels take more memory than a frame may"));
}

Result<void> check_memory(const VideoGroup& group, std::uint64_t blocks,
                          const DecodeLimits& limits) {
  const std::uint64_t points = std::min<std::uint64_t>(kPointsOfBlock * blocks, group.pixels());
  if (group.pixels() * kBytesOfPixel + points * kBytesOfPoint > limits.max_memory)
    return too_large(group);
  return {};
}

}  // namespace

Result<void> VideoFrameReader::begin(ByteView header, const DecodeLimits& limits) {
  ParsedVideoGroup parsed = TRY(read_video_group(header));
  if (!parsed.rest.empty()) return fail("the video's header is followed by something");
  const VideoGroup& group = parsed.group;
  if (group.pixels() > limits.max_points) return too_large(group);
  TRY(check_memory(group, 0, limits));
  group_ = std::make_shared<const VideoGroup>(std::move(parsed.group));
  occupancy_.emplace(*group_);
  colors_ = group_->colors;
  next_ = 0;
  return {};
}

Result<CodedVideoFrame> VideoFrameReader::read(const Chunks<ByteView>& chunks,
                                               const DecodeLimits& limits) {
  if (read_chunk(chunks.geometry, ChunkKind::geometry, 1, 0)) group_.reset();
  const auto tag = static_cast<FrameTag>(group_ ? next_ : 0);
  const ParsedChunk geometry = TRY(read_video_chunk(chunks.geometry, ChunkKind::geometry, tag));
  const Parts parts = TRY(read_parts(geometry.payload));
  if (group_ && !parts.group.empty()) return fail("the video's header comes again");
  if (!group_) TRY(begin(parts.group, limits));
  if (next_ == group_->frames) return fail("the video's group has more frames than it says");
  ByteView colors;
  if (!chunks.colors.empty())
    colors = TRY(read_video_chunk(chunks.colors, ChunkKind::colors, tag)).payload;
  colors_ = colors_ && !colors.empty();
  BlockMask blocks = TRY(occupancy_->decode(parts.occupancy));
  TRY(check_memory(*group_, static_cast<std::uint64_t>(std::ranges::count(blocks.on, 1)), limits));
  return CodedVideoFrame{group_,          next_++,     std::move(blocks),
                         parts.leftovers, parts.depth, colors_ ? colors : ByteView()};
}

Result<CodedVideoFrame> VideoFrameReader::next(const Chunks<ByteView>& chunks,
                                               const DecodeLimits& limits) {
  auto frame = or_out_of_memory([&] { return read(chunks, limits); });
  if (!frame) reset();
  return frame;
}

VideoPictures undecoded(CodedVideoFrame frame) {
  return {std::move(frame.group),
          std::move(frame.blocks),
          {},
          {},
          Bytes(frame.leftovers.begin(), frame.leftovers.end())};
}

Result<DecodedFrame> frame_of(const VideoPictures& pictures, const DecodeLimits& limits) {
  return or_out_of_memory([&] { return make_frame(pictures, limits, {true, true}); });
}

Result<PointCloud> points_of(const VideoPictures& pictures, const DecodeLimits& limits,
                             bool normals) {
  return or_out_of_memory([&]() -> Result<PointCloud> {
    DecodedFrame frame = TRY(make_frame(pictures, limits, {normals, false}));
    return std::move(frame.cloud);
  });
}

}  // namespace pointreel
