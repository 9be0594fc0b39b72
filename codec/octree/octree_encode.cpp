#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "codec/core/build.h"
#include "codec/core/scalar_fields.h"
#include "codec/octree/color_space.h"
#include "codec/octree/frame_structure.h"
#include "codec/octree/geometry_chunks.h"
#include "codec/octree/leaf_attributes.h"
#include "codec/octree/normal_noise.h"
#include "codec/octree/normal_space.h"
#include "codec/octree/octree_codec.h"
#include "codec/octree/octree_frame.h"
#include "codec/octree/scalar_coder.h"
#include "common/base/concat.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

FrameTag tag_of(const Svo& svo) {
  return static_cast<FrameTag>(
      XXH3_64bits_withSeed(svo.masks.data(), svo.masks.size(),
                           XXH3_64bits(&svo.cube, sizeof(svo.cube)) + svo.leaf_count()));
}

/// Encodes an attribute that is stored exactly, each layer as differences from the layer before.
class AttributeEncoder {
 public:
  AttributeEncoder(ChunkKind kind, CodeShape shape) : kind_(kind), shape_(shape) {}

  void encode_layer(const Svo& svo, Codes codes, ChunkHeader header, FrameTag tag, Bytes& out) {
    const int level = header.last_level;
    const Codes predicted =
        header.layer == 0 ? Codes(codes.size()) : inherit(svo, previous_, level_, level);
    header.kind = kind_;
    if (header.entropy == Entropy::context) header.entropy = Entropy::zstd;
    pack_chunk(header, tag, code_differences(codes, predicted, shape_), out);
    previous_ = std::move(codes);
    level_ = level;
  }

 private:
  ChunkKind kind_;
  CodeShape shape_;
  Codes previous_;
  int level_ = 0;
};

/// The last level of each layer of a tree.
std::vector<int> layer_ends(int depth, int layers) {
  std::vector<int> ends;
  for (int layer = 0; layer < layers; ++layer) ends.push_back(last_level_of_layer(layer, depth));
  return ends;
}

/// Encodes a transformed attribute of all layers into their chunks: exactly, if there are no steps.
void encode_transformed(const FrameStructure& structure, const std::vector<Short4>& leaves,
                        ChunkKind kind, const std::optional<CoefficientSteps>& frame_steps,
                        FrameTag tag, std::vector<Chunks<Bytes>>& layers) {
  const Svo& svo = structure.svo();
  TransformEncoder encoder(structure, attribute_of(kind), leaves, !frame_steps);
  for (std::size_t layer = 0; layer < layers.size(); ++layer) {
    const int end = structure.layer_ends()[layer];
    const ChunkHeader header{kind, Entropy::none, static_cast<std::uint8_t>(layer),
                             static_cast<std::uint8_t>(end), 0};
    const CoefficientSteps steps =
        frame_steps ? layer_steps(*frame_steps, svo.leaf_count(), svo.node_count(end))
                    : kExactSteps;
    pack_chunk(header, tag, encoder.encode_layer(steps), chunk_of(layers[layer], kind));
  }
}

template <auto convert, class Attribute>
std::vector<Short4> values_of(const std::vector<Attribute>& attributes) {
  std::vector<Short4> values(attributes.size());
  std::transform(attributes.begin(), attributes.end(), values.begin(),
                 [](const Attribute& attribute) { return convert(attribute); });
  return values;
}

Result<void> check(const PointCloud& cloud, const Cube& cube, const OctreeOptions& options) {
  const auto refused = [](std::string message) {
    return fail(ErrorCode::argument, std::move(message));
  };
  if (cloud.size() >= std::size_t{1} << 31) {
    return fail(ErrorCode::limit, "a frame can hold fewer than 2^31 points: thin them out");
  }
  if (options.color_quality < 1 || options.color_quality > kLosslessColorQuality) {
    return refused(concat("colour quality ", options.color_quality, " is not between 1 and 100"));
  }
  if (options.normal_quality < 1 || options.normal_quality > kBestNormalQuality) {
    return refused(concat("normal quality ", options.normal_quality, " is not between 1 and 100"));
  }
  if (options.slabs < 0 || options.slabs > kMostSlabs) {
    return refused(concat(options.slabs, " slabs are not between 0 and ", kMostSlabs));
  }
  for (const ScalarStep& step : options.scalar_steps) {
    if (!(step.step > 0.0) || !std::isfinite(step.step))
      return refused(concat("the step of a scalar field, ", step.step, ", is not above 0"));
  }
  if (options.scalars) TRY(check_scalars(cloud));
  return check_codable(cube);
}

Result<EncodedFrame> encode(const PointCloud& cloud, const Cube& cube, const OctreeOptions& options,
                            bool normals, bool colors, const Executor& executor) {
  TRY(check(cloud, cube, options));
  const SortedToDepth points =
      TRY(sort_to_depth(cloud, cube, coding_rule(options.depth, cloud.size())));
  const Svo svo = build_svo(points.sorted, cloud.empty() ? 0 : points.depth);

  FrameHeader frame;
  frame.codec = Codec::octree;
  frame.depth = static_cast<std::uint8_t>(svo.depth);
  frame.has_colors = colors && cloud.has_colors();
  frame.has_normals = normals && cloud.has_normals();
  frame.colors_16_bit = frame.has_colors && !colors_fit_8_bits(cloud);
  const bool lossless_colors = options.color_quality == kLosslessColorQuality;
  // The transform gives far fewer bytes, also without a loss. It has no room for 16 bits.
  frame.colors_transformed =
      frame.has_colors &&
      (!lossless_colors || (options.entropy == Entropy::context && !frame.colors_16_bit));
  frame.normals_transformed = frame.has_normals && options.normal_quality < kBestNormalQuality;
  frame.layers = static_cast<std::uint8_t>(layer_count(svo.depth));
  frame.source_points = static_cast<std::uint32_t>(cloud.size());
  frame.coded_points = svo.leaf_count();
  frame.cube = cube;

  EncodedFrame encoded;
  encoded.source_points = frame.source_points;
  encoded.coded_points = frame.coded_points;
  encoded.depth = svo.depth;
  encoded.layers.resize(frame.layers);
  const FrameTag tag = tag_of(svo);
  const CodeShape shape = color_shape(frame);
  const bool exact_colors = frame.has_colors && !frame.colors_transformed;
  const bool exact_normals = frame.has_normals && !frame.normals_transformed;
  std::vector<glm::u16vec3> node_colors;
  if (exact_colors) node_colors = mean_colors(svo, cloud, points.sorted);
  std::vector<glm::i16vec3> node_normals;
  if (exact_normals) node_normals = mean_normals(svo, cloud, points.sorted);
  const int slabs = options.slabs > 0 ? options.slabs : default_slabs(svo.leaf_count());
  auto geometry = TRY(GeometryEncoder::create(options.entropy, options.tables, slabs));
  AttributeEncoder color_encoder(ChunkKind::colors, shape);
  AttributeEncoder normal_encoder(ChunkKind::normals, kNormalShape);
  int first_level = 0;
  for (int layer = 0; layer < frame.layers; ++layer) {
    Chunks<Bytes>& out = encoded.layers[static_cast<std::size_t>(layer)];
    const int last_level = last_level_of_layer(layer, svo.depth);
    const ChunkHeader header{ChunkKind::geometry, options.entropy, static_cast<std::uint8_t>(layer),
                             static_cast<std::uint8_t>(last_level), 0};
    if (layer == 0) write_frame_header(frame, tag, out.geometry);
    geometry.encode_layer(svo, first_level, header, tag, executor, out.geometry);

    const std::size_t end = svo.level_begin[static_cast<std::size_t>(last_level)];
    const std::size_t count = svo.node_count(last_level);
    if (exact_colors) {
      color_encoder.encode_layer(svo, color_codes(node_colors.data() + end, count, shape.bits),
                                 header, tag, out.colors);
    }
    if (exact_normals) {
      normal_encoder.encode_layer(svo, normal_codes(node_normals.data() + end, count), header, tag,
                                  out.normals);
    }
    first_level = last_level;
  }
  const bool scalars = options.scalars && cloud.has_scalars() && !cloud.empty();
  if (!frame.colors_transformed && !frame.normals_transformed && !scalars) return encoded;
  const FrameStructure structure(svo, layer_ends(svo.depth, frame.layers));
  if (frame.colors_transformed) {
    std::optional<CoefficientSteps> steps;
    if (!lossless_colors) steps = color_steps(options.color_quality);
    const std::vector<glm::u16vec3> of_leaves = mean_leaf_colors(svo, cloud, points.sorted);
    encode_transformed(structure,
                       steps ? values_of<value_from_color>(of_leaves)
                             : values_of<exact_value_from_color>(of_leaves),
                       ChunkKind::colors, steps, tag, encoded.layers);
  }
  if (frame.normals_transformed) {
    const std::vector<Short4> normals_of_leaves =
        values_of<value_from_normal>(mean_leaf_normals(svo, cloud, points.sorted));
    CoefficientSteps steps = normal_steps(options.normal_quality);
    if (options.normals_follow_noise) {
      steps = no_finer_than_noise(steps, normal_noise(svo, normals_of_leaves));
    }
    encode_transformed(structure, normals_of_leaves, ChunkKind::normals, steps, tag,
                       encoded.layers);
  }
  if (!scalars) return encoded;
  const Bytes payload =
      encode_scalars(structure, cloud, points.sorted, options.scalar_steps, executor);
  if (!payload.empty()) {
    const ChunkHeader header{ChunkKind::scalars, Entropy::none, frame.layers, frame.depth, 0};
    pack_chunk(header, tag, payload, encoded.layers.emplace_back().geometry);
    encoded.has_scalars = true;
  }
  return encoded;
}

}  // namespace

Result<EncodedFrame> encode_octree(const PointCloud& cloud, const Cube& cube,
                                   const OctreeOptions& options, bool normals, bool colors,
                                   const Executor& executor) {
  return or_out_of_memory([&] { return encode(cloud, cube, options, normals, colors, executor); });
}

}  // namespace pointreel
