#include "codec/octree/frame_header.h"

#include <cmath>

#include "common/base/byte_io.h"
#include "common/base/concat.h"
#include "pointreel/octree.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace pointreel {
namespace {

constexpr std::uint32_t kFrameMagic = 0x46525250u;  // "PRRF"
constexpr std::uint16_t kChunkMagic = 0x4352u;      // "RC"

enum Flags : std::uint8_t {
  kColors = 1,
  kNormals = 2,
  kColors16 = 4,
  kTransformed = 8,
  kNormalsTransformed = 16
};

/// The checksum of a header up to the checksum itself, and of its payload.
std::uint64_t checksum(ByteView header, ByteView payload) {
  return XXH3_64bits_withSeed(payload.data(), payload.size(),
                              XXH3_64bits(header.data(), header.size()));
}

}  // namespace

bool is_codable(const Cube& cube) {
  return std::isfinite(cube.origin.x) && std::isfinite(cube.origin.y) &&
         std::isfinite(cube.origin.z) && cube.edge >= 1e-30 && cube.edge <= 1e30;
}

Result<void> check_codable(const Cube& cube) {
  if (is_codable(cube)) return {};
  return fail(ErrorCode::argument,
              concat("a cube with the edge ", cube.edge, " cannot be coded: scale the points"));
}

void write_frame_header(const FrameHeader& header, FrameTag tag, Bytes& out) {
  const std::size_t begin = out.size();
  ByteWriter writer(out);
  writer.put(kFrameMagic);
  writer.put(kFrameVersion);
  writer.put(static_cast<std::uint8_t>(header.codec));
  writer.put(header.depth);
  writer.put(static_cast<std::uint8_t>(
      (header.has_colors ? kColors : 0) | (header.has_normals ? kNormals : 0) |
      (header.colors_16_bit ? kColors16 : 0) | (header.colors_transformed ? kTransformed : 0) |
      (header.normals_transformed ? kNormalsTransformed : 0)));
  writer.put(header.source_points);
  writer.put(header.coded_points);
  writer.put(static_cast<std::uint32_t>(header.layers));
  writer.put(tag);
  writer.put(header.cube.origin.x);
  writer.put(header.cube.origin.y);
  writer.put(header.cube.origin.z);
  writer.put(header.cube.edge);
  writer.put(checksum(ByteView(out).subspan(begin), {}));
}

Result<ParsedFrameHeader> read_frame_header(ByteView bytes) {
  ByteReader reader(bytes);
  if (reader.get<std::uint32_t>() != kFrameMagic) return fail("not a Pointreel frame");
  const auto version = reader.get<std::uint8_t>();
  if (version != kFrameVersion) {
    return fail(ErrorCode::unsupported,
                concat("frame has format version ", version, ", but only version ", kFrameVersion,
                       " is supported: update Pointreel"));
  }
  const auto codec = reader.get<std::uint8_t>();
  ParsedFrameHeader parsed;
  FrameHeader& header = parsed.header;
  header.depth = reader.get<std::uint8_t>();
  const auto flags = reader.get<std::uint8_t>();
  header.source_points = reader.get<std::uint32_t>();
  header.coded_points = reader.get<std::uint32_t>();
  const auto layers = reader.get<std::uint32_t>();
  parsed.tag = reader.get<std::uint32_t>();
  header.cube.origin.x = reader.get<double>();
  header.cube.origin.y = reader.get<double>();
  header.cube.origin.z = reader.get<double>();
  header.cube.edge = reader.get<double>();
  const auto expected = reader.get<std::uint64_t>();
  if (!reader.ok()) return fail("frame header is cut short");
  if (expected != checksum(bytes.first(kFrameHeaderSize - sizeof(expected)), {})) {
    return fail("frame header is damaged: its checksum does not match");
  }
  if (codec != static_cast<std::uint8_t>(Codec::octree) &&
      codec != static_cast<std::uint8_t>(Codec::draco)) {
    return fail(ErrorCode::unsupported,
                concat("frame has unknown codec ", codec, ": update Pointreel"));
  }
  if (header.depth > kMaxDepth ||
      flags > (kColors | kNormals | kColors16 | kTransformed | kNormalsTransformed) || layers < 1 ||
      layers > 255 || header.coded_points > header.source_points || !is_codable(header.cube)) {
    return fail("frame header has a field out of range");
  }
  header.codec = static_cast<Codec>(codec);
  header.has_colors = flags & kColors;
  header.has_normals = flags & kNormals;
  header.colors_16_bit = flags & kColors16;
  header.colors_transformed = flags & kTransformed;
  header.normals_transformed = flags & kNormalsTransformed;
  header.layers = static_cast<std::uint8_t>(layers);
  parsed.rest = reader.rest();
  return parsed;
}

void write_chunk(const ChunkHeader& header, FrameTag tag, ByteView payload, Bytes& out) {
  const std::size_t begin = out.size();
  ByteWriter writer(out);
  writer.put(kChunkMagic);
  writer.put(static_cast<std::uint8_t>(static_cast<unsigned>(header.kind) |
                                       static_cast<unsigned>(header.entropy) << 4));
  writer.put(header.layer);
  writer.put(tag);
  writer.put(static_cast<std::uint32_t>(header.last_level));
  writer.put(header.raw_size);
  writer.put(checksum(ByteView(out).subspan(begin), payload));
  out.insert(out.end(), payload.begin(), payload.end());
}

Result<ParsedChunk> read_chunk(ByteView bytes, ChunkKind kind, std::uint8_t layer, FrameTag tag) {
  ByteReader reader(bytes);
  const auto magic = reader.get<std::uint16_t>();
  const auto kind_and_entropy = reader.get<std::uint8_t>();
  const auto stored_layer = reader.get<std::uint8_t>();
  const auto stored_tag = reader.get<std::uint32_t>();
  const auto last_level = reader.get<std::uint32_t>();
  const auto raw_size = reader.get<std::uint32_t>();
  const auto expected = reader.get<std::uint64_t>();
  if (!reader.ok()) return fail("chunk header is cut short");
  if (magic != kChunkMagic) return fail("not a Pointreel chunk");
  if (expected != checksum(bytes.first(kChunkHeaderSize - sizeof(expected)), reader.rest())) {
    return fail("chunk is damaged or cut short: its checksum does not match");
  }
  const unsigned entropy = kind_and_entropy >> 4;
  if ((kind_and_entropy & 15u) != static_cast<unsigned>(kind) || stored_layer != layer) {
    return fail("chunk is of another kind or layer than expected");
  }
  if (stored_tag != tag) return fail("chunk belongs to another frame");
  if (entropy > static_cast<unsigned>(Entropy::context)) {
    return fail(ErrorCode::unsupported,
                concat("chunk has unknown entropy coding ", entropy, ": update Pointreel"));
  }
  if (last_level > kMaxDepth) return fail("chunk header has a field out of range");
  ParsedChunk chunk;
  chunk.header = {kind, static_cast<Entropy>(entropy), layer, static_cast<std::uint8_t>(last_level),
                  raw_size};
  chunk.payload = reader.rest();
  return chunk;
}

}  // namespace pointreel
