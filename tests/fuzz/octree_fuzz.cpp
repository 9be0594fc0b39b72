#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>

#include "codec/octree/context_tables.h"
#include "codec/octree/frame_header.h"
#include "codec/octree/octree_codec.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/draco.h"
#include "pointreel/octree.h"
#include "tests/fuzz/target.h"

namespace pointreel::fuzz::octree {

const DecodeLimits kLimits{1u << 20};

/// Removes `size` bytes, or all that are left, from the front.
ByteView take(ByteView& bytes, std::size_t size) {
  const ByteView taken = bytes.first(std::min(size, bytes.size()));
  bytes = bytes.subspan(taken.size());
  return taken;
}

std::size_t take_length(ByteView& bytes) {
  const ByteView two = take(bytes, 2);
  return two.size() < 2 ? 0 : static_cast<std::size_t>(two[0] | two[1] << 8);
}

/// Takes chunks from the input as they are, each after its length.
EncodedFrame raw_frame(ByteView bytes) {
  EncodedFrame frame;
  frame.layers.resize(3);
  for (Chunks<Bytes>& layer : frame.layers) {
    for (Bytes* part : {&layer.geometry, &layer.colors, &layer.normals}) {
      const ByteView chunk = take(bytes, take_length(bytes));
      part->assign(chunk.begin(), chunk.end());
    }
  }
  return frame;
}

/// Takes fields and payloads from the input and adds correct checksums, so that the decoder itself
/// is tested and not only the checks before it.
EncodedFrame forged_frame(ByteView bytes) {
  const ByteView fields = take(bytes, 4);
  if (fields.size() < 4) return {};
  FrameHeader header;
  header.depth = static_cast<std::uint8_t>(fields[0] % (kMaxDepth + 2));
  header.has_colors = fields[1] & 1;
  header.has_normals = fields[1] & 2;
  header.colors_16_bit = fields[1] & 4;
  header.colors_transformed = fields[1] & 8;
  header.normals_transformed = fields[1] & 16;
  header.layers = static_cast<std::uint8_t>(layer_count(std::min<int>(header.depth, kMaxDepth)));
  header.coded_points = header.source_points = fields[2] | fields[3] << 8;
  EncodedFrame frame;
  frame.layers.resize(header.layers);
  for (std::uint8_t layer = 0; layer < header.layers; ++layer) {
    Chunks<Bytes>& out = frame.layers[layer];
    if (layer == 0) write_frame_header(header, 1, out.geometry);
    std::uint8_t kind = 0;
    for (Bytes* part : {&out.geometry, &out.colors, &out.normals}) {
      const ByteView coding = take(bytes, 1);
      const std::size_t raw_size = take_length(bytes);
      const ByteView payload = take(bytes, take_length(bytes));
      ChunkHeader chunk;
      chunk.kind = static_cast<ChunkKind>(kind++);
      chunk.entropy = coding.empty() ? Entropy::none : static_cast<Entropy>(coding[0] % 3);
      chunk.layer = layer;
      chunk.last_level = static_cast<std::uint8_t>(
          last_level_of_layer(layer, std::min<int>(header.depth, kMaxDepth)));
      chunk.raw_size =
          static_cast<std::uint32_t>(chunk.entropy == Entropy::none ? payload.size() : raw_size);
      write_chunk(chunk, 1, payload, *part);
    }
  }
  if (fields[1] & 32) {
    const ByteView payload = take(bytes, take_length(bytes));
    write_chunk({ChunkKind::scalars, Entropy::none, header.layers,
                 std::min<std::uint8_t>(header.depth, kMaxDepth),
                 static_cast<std::uint32_t>(payload.size())},
                1, payload, frame.layers.emplace_back().geometry);
  }
  return frame;
}

/// Any tables that can be read must code the points at the beginning of the input losslessly.
void check_tables(ByteView bytes) {
  (void)read_table_file(bytes);
  const ByteView points = take(bytes, 48);
  const auto tables = parse_tables(bytes, tables_of_number(kNewestTables)->get());
  if (!tables) return;
  OctreeOptions options{Entropy::context, DepthRule::fixed(points.empty() ? 0 : points[0] % 12)};
  options.tables = std::make_shared<const ContextTables>(*tables);
  PointCloud cloud;
  for (std::size_t i = 0; i + 2 < points.size(); i += 3) {
    cloud.positions.push_back(glm::vec3(points[i], points[i + 1], points[i + 2]) / 256.0f);
  }
  const auto frame = encode_octree(cloud, Cube{}, options, false, false);
  DecodeLimits limits = kLimits;
  limits.tables = options.tables.get();
  options.entropy = Entropy::none;
  const auto plain = encode_octree(cloud, Cube{}, options, false, false);
  if (!frame || !plain) std::abort();
  const auto tree = decode_octree_tree(layer_views(frame->layers), limits);
  const auto same = decode_octree_tree(layer_views(plain->layers), kLimits);
  if (!tree || !same || tree->svo.masks != same->svo.masks) std::abort();
}

}  // namespace pointreel::fuzz::octree

/// A frame that decodes must be consistent, and stay the same when it is encoded and decoded again.
FUZZ_TARGET(octree) {
  if (input.empty()) return;
  const ByteView bytes = input.subspan(1);
  if (input[0] == 0xff) {
    check_tables(bytes);
    return;
  }
  const EncodedFrame given = input[0] & 1 ? forged_frame(bytes) : raw_frame(bytes);
  const auto tree = decode_octree_tree(layer_views(given.layers), kLimits);
  const auto frame = decode_frame(layer_views(given.layers), kLimits);
  DecodeLimits cut_off = kLimits;
  cut_off.inner_nodes = true;
  cut_off.leaves = false;
  cut_off.depth = input[0] >> 4;
  if (const auto coarse = decode_frame(layer_views(given.layers), cut_off)) {
    const std::size_t nodes = coarse->svo->node_count();
    const NodeAttributes& attributes = coarse->attributes;
    if (!attributes.colors.empty() && attributes.colors.size() != nodes) std::abort();
    if (!attributes.normals.empty() && attributes.normals.size() != nodes) std::abort();
    if (coarse->svo->depth > cut_off.depth || !coarse->cloud.empty()) std::abort();
  } else if (tree) {
    std::abort();  // what decodes as a whole must also decode in part
  }
  if (!tree || !frame) return;
  if (tree->svo.leaf_count() != frame->cloud.size()) std::abort();
  if (frame->cloud.has_colors() && frame->cloud.colors.size() != frame->cloud.size()) std::abort();
  for (const ScalarField& field : frame->cloud.scalars) {
    if (field.values.size() != frame->cloud.size()) std::abort();
    for (const float value : field.values)
      if (std::isinf(value)) std::abort();
  }

  // Cells are restored exactly if floats tell them apart, which they always do in a cube at the
  // origin.
  PointCloud cloud = frame->cloud;
  cloud.origin = glm::dvec3(0.0);
  const Cube cube{glm::dvec3(0.0), frame->cube.edge};
  const OctreeOptions options{input[0] & 4 ? Entropy::context : Entropy::zstd,
                              DepthRule::fixed(tree->svo.depth), 1 + input[0] % 100,
                              1 + input[0] % 100};
  const auto again = encode_frame(cloud, cube, {options, true, true});
  if (!again) std::abort();
  const auto twice = decode_octree_tree(layer_views(again->layers), kLimits);
  if (!twice || (!cloud.empty() && twice->svo.masks != tree->svo.masks)) std::abort();
  if (twice->scalars.size() > frame->cloud.scalars.size()) std::abort();
}
