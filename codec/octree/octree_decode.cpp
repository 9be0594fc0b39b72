#include <algorithm>
#include <bit>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "codec/octree/color_space.h"
#include "codec/octree/frame_structure.h"
#include "codec/octree/geometry_chunks.h"
#include "codec/octree/leaf_attributes.h"
#include "codec/octree/memory_budget.h"
#include "codec/octree/normal_space.h"
#include "codec/octree/octree_codec.h"
#include "codec/octree/octree_frame.h"
#include "codec/octree/scalar_coder.h"
#include "common/base/concat.h"
#include "common/base/for_each.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

/// Decodes an attribute that is stored exactly, layer by layer from the base on.
class AttributeDecoder {
 public:
  AttributeDecoder(ChunkKind kind, CodeShape shape) : kind_(kind), shape_(shape) {}

  /// `bytes`: the layer's chunk, or nothing if it was left out.
  Result<void> decode_layer(const Svo& svo, ByteView bytes, int layer, int last_level,
                            FrameTag tag) {
    if (layer == 0) {
      present_ = !bytes.empty();
      if (present_) codes_.resize(svo.node_count(last_level));
    } else if (present_) {
      codes_ = inherit(svo, codes_, level_, last_level);
    }
    level_ = last_level;
    if (bytes.empty() || !present_) return {};
    const ParsedChunk chunk = TRY(read_chunk(bytes, kind_, static_cast<std::uint8_t>(layer), tag));
    if (chunk.header.last_level != last_level) return fail("layer ends at an unexpected level");
    const Bytes raw = TRY(unpack_chunk(chunk, shape_.bytes(codes_.size())));
    codes_ = add_differences(raw, codes_, shape_);
    return {};
  }

  const Codes& codes() const { return codes_; }

 private:
  ChunkKind kind_;
  CodeShape shape_;
  bool present_ = false;
  int level_ = 0;
  Codes codes_;
};

Result<void> check_stopped(const DecodeLimits& limits) {
  if (limits.stopped && limits.stopped()) return fail(ErrorCode::cancelled, "decoding was stopped");
  return {};
}

/// Decodes a transformed attribute from the base down to the first layer that lacks it, or to level
/// `depth`. Returns null if the base lacks it. `may_be_exact`: only colours of 8 bits may be.
Result<std::unique_ptr<TransformDecoder>> decode_transformed(
    const FrameStructure& structure, const std::vector<Chunks<ByteView>>& layers, int depth,
    ChunkKind kind, bool may_be_exact, FrameTag tag, const DecodeLimits& limits) {
  if (chunk_of(layers.front(), kind).empty()) return nullptr;
  const std::vector<int>& last_levels = structure.layer_ends();
  auto decoder = std::make_unique<TransformDecoder>(structure, attribute_of(kind));
  for (std::size_t layer = 0; layer < last_levels.size(); ++layer) {
    const ByteView bytes = chunk_of(layers[layer], kind);
    if (bytes.empty() || (layer > 0 && last_levels[layer - 1] >= depth)) break;
    TRY(check_stopped(limits));
    const ParsedChunk chunk = TRY(read_chunk(bytes, kind, static_cast<std::uint8_t>(layer), tag));
    if (chunk.header.entropy != Entropy::none || chunk.header.raw_size != chunk.payload.size() ||
        chunk.header.last_level != last_levels[layer]) {
      return fail("chunk header has a field out of range");
    }
    TRY(decoder->decode_layer(chunk.payload, last_levels[layer], depth));
    if (decoder->exact() && !may_be_exact) return fail("a field is out of range");
  }
  decoder->inherit(std::min(depth, last_levels.back()));
  return decoder;
}

/// Appends what `convert` makes of the values: convert(values, attributes) sets one for each.
template <class Attribute, class Convert>
void add_attributes(std::span<const Short4> values, Convert convert, std::vector<Attribute>& out) {
  const std::size_t begin = out.size();
  out.resize(begin + values.size());
  convert(values, out.data() + begin);
}

/// Converts each of many values by itself.
template <auto convert>
constexpr auto kEach = [](std::span<const Short4> values, auto* out) {
  std::transform(values.begin(), values.end(), out, convert);
};

template <class Convert>
void set_colors(const TransformDecoder& decoder, const DecodeLimits& limits, Convert convert,
                OctreeFrame& frame) {
  if (!limits.inner_nodes) {
    add_attributes(decoder.values(frame.svo.depth), convert, frame.colors);
    return;
  }
  auto& all = frame.nodes.colors;
  add_attributes(decoder.values(), convert, all);
  if (limits.leaves) frame.colors.assign(all.begin() + frame.svo.internal_count(), all.end());
}

/// Gives the nodes below those that have normals, down to `depth`, the normals of their parents.
void inherit_normals(const Svo& svo, int depth, std::vector<glm::i16vec3>& normals) {
  // Eight are written whatever the number of children: the next node's write over those too many.
  constexpr std::size_t kRoom = 8;
  for (int level = 0; level < depth; ++level) {
    const std::size_t l = static_cast<std::size_t>(level);
    std::size_t child = svo.level_begin[l + 1];
    if (normals.size() > child) continue;
    normals.resize(child + svo.node_count(level + 1) + kRoom);
    for (std::uint32_t node = svo.level_begin[l]; node < svo.level_begin[l + 1]; ++node) {
      const glm::i16vec3 normal = normals[node];
      for (std::size_t i = 0; i < kRoom; ++i) normals[child + i] = normal;
      child += static_cast<std::size_t>(std::popcount(svo.masks[node]));
    }
    normals.resize(child);
  }
}

void set_normals(const TransformDecoder& decoder, const DecodeLimits& limits, int depth,
                 OctreeFrame& frame) {
  if (limits.leaves || !limits.inner_nodes) {
    add_attributes(decoder.values(frame.svo.depth), normals_from_values, frame.normals);
  }
  if (limits.inner_nodes) {
    const std::span<const Short4> values = decoder.values();
    const std::size_t inner = std::min<std::size_t>(values.size(), frame.svo.internal_count());
    std::vector<glm::i16vec3>& normals = frame.nodes.normals;
    normals.reserve(frame.svo.node_count());
    add_attributes(values.first(inner), kEach<mean_normal_from_value>, normals);
    add_attributes(values.subspan(inner), kEach<short_normal_from_value>, normals);
    inherit_normals(frame.svo, std::min(depth, frame.svo.depth), normals);
  }
}

/// Decodes the colours of a frame if they are transformed.
Result<void> decode_colors(const FrameStructure& structure,
                           const std::vector<Chunks<ByteView>>& layers, int depth,
                           const ParsedFrameHeader& parsed, const DecodeLimits& limits,
                           OctreeFrame& frame) {
  if (!parsed.header.colors_transformed) return {};
  const auto decoder =
      TRY(at_place("colors", decode_transformed(structure, layers, depth, ChunkKind::colors,
                                                !parsed.header.colors_16_bit, parsed.tag, limits)));
  if (decoder == nullptr) return {};
  if (decoder->exact()) {
    set_colors(*decoder, limits, kEach<color_from_exact_value>, frame);
  } else if (parsed.header.colors_16_bit) {
    set_colors(*decoder, limits, kEach<color_16_from_value>, frame);
  } else {
    set_colors(*decoder, limits, colors_from_values, frame);
  }
  return {};
}

/// The same for normals.
Result<void> decode_normals(const FrameStructure& structure,
                            const std::vector<Chunks<ByteView>>& layers, int depth,
                            const ParsedFrameHeader& parsed, const DecodeLimits& limits,
                            OctreeFrame& frame) {
  if (!parsed.header.normals_transformed) return {};
  const int last = limits.leaves ? depth : std::clamp(limits.normals_depth, 0, depth);
  const auto decoder =
      TRY(at_place("normals", decode_transformed(structure, layers, last, ChunkKind::normals, false,
                                                 parsed.tag, limits)));
  if (decoder != nullptr) set_normals(*decoder, limits, depth, frame);
  return {};
}

/// Decodes one scalar field.
Result<void> decode_scalars(const FrameStructure& structure, const ScalarStreams& streams,
                            const DecodeLimits& limits, ScalarField& field) {
  TRY(check_stopped(limits));
  field = TRY(at_place("scalar fields", decode_scalar(structure, streams)));
  return {};
}

/// Cuts the tree and its attributes off at `depth`, for callers that do not need the leaves.
void cut_off(OctreeFrame& frame, int depth) {
  frame.svo = truncate(frame.svo, depth);
  const std::size_t nodes = frame.svo.node_count();
  if (frame.nodes.colors.size() > nodes) frame.nodes.colors.resize(nodes);
  if (frame.nodes.normals.size() > nodes) frame.nodes.normals.resize(nodes);
  frame.colors.clear();
  frame.normals.clear();
}

/// Adds the nodes' means of those attributes that were coded for the leaves alone.
void add_means(OctreeFrame& frame, const Executor& executor) {
  PointCloud leaves;
  if (frame.nodes.colors.empty()) leaves.colors.swap(frame.colors);
  if (frame.nodes.normals.empty()) leaves.normals.swap(frame.normals);
  NodeAttributes means = mean_attributes(frame.svo, leaves, executor);
  if (leaves.has_colors()) {
    frame.nodes.colors = std::move(means.colors);
    frame.colors.swap(leaves.colors);
  }
  if (leaves.has_normals()) {
    frame.nodes.normals = std::move(means.normals);
    frame.normals.swap(leaves.normals);
  }
}

/// What transformed attributes need to know of a tree.
FrameStructure structure_for(const Svo& svo, const std::vector<int>& last_levels,
                             const FrameHeader& header, const std::vector<Chunks<ByteView>>& layers,
                             const std::vector<ScalarStreams>& scalars) {
  LevelSet predicted = 0;
  int first_level = 0;
  for (std::size_t layer = 0; layer < last_levels.size(); ++layer) {
    const auto add = [&](ByteView chunk, bool transformed) {
      if (!transformed || chunk.size() < kChunkHeaderSize) return;
      // If the chunk is damaged, it is refused later.
      predicted |= TransformDecoder::predicted_levels(chunk.subspan(kChunkHeaderSize), first_level);
    };
    add(layers[layer].colors, header.colors_transformed);
    add(layers[layer].normals, header.normals_transformed);
    for (const ScalarStreams& field : scalars)
      predicted |= TransformDecoder::predicted_levels(field.layers[layer], first_level);
    first_level = last_levels[layer];
  }
  return {svo, last_levels, predicted};
}

/// Takes the memory for the masks of a layer, their unpacking, and the index of their children.
Result<void> take_geometry(const ParsedChunk& chunk, int levels, std::uint32_t points,
                           MemoryBudget& budget) {
  // If there claim to be more masks than these, the chunk is refused for that.
  const std::uint64_t masks =
      std::min({std::uint64_t{chunk.header.raw_size}, max_raw_size(chunk.payload.size()),
                std::uint64_t{points} * static_cast<unsigned>(levels)});
  TRY(budget.take(masks, 8));
  if (chunk.header.entropy != Entropy::context) return {};
  // Only the two finest levels are kept, which have at most as many nodes each as there are points.
  return budget.take(std::min<std::uint64_t>(masks, 2 * std::uint64_t{points}), 40);
}

/// Takes the memory for one attribute, whose chunk in the base layer is `base`.
Result<void> take_attribute(const Svo& svo, ByteView base, bool transformed,
                            const DecodeLimits& limits, MemoryBudget& budget) {
  if (base.empty()) return {};
  const std::uint64_t nodes = svo.node_count(), leaves = svo.leaf_count();
  if (limits.inner_nodes) TRY(budget.take(nodes, 2 * sizeof(glm::u16vec3)));
  if (limits.leaves) TRY(budget.take(leaves, sizeof(glm::vec3)));
  if (!transformed) return budget.take(leaves, 4 * sizeof(glm::u16vec3) + sizeof(glm::vec3));
  // The values, and the planes of the level whose planes are largest.
  TRY(budget.take(nodes, sizeof(Short4) + 1));
  return budget.take(svo.internal_count(), 6 * sizeof(Short4));
}

/// The scalar fields that are to be decoded: none unless the whole tree was.
Result<std::vector<ScalarStreams>> find_scalars(const std::vector<Chunks<ByteView>>& layers,
                                                const ParsedFrameHeader& parsed, const Svo& svo,
                                                const DecodeLimits& limits, MemoryBudget& budget) {
  const std::size_t number = parsed.header.layers;
  if (!limits.scalars || layers.size() <= number || layers[number].geometry.empty() ||
      svo.depth != parsed.header.depth || (!limits.leaves && limits.depth < svo.depth)) {
    return {};
  }
  const ParsedChunk chunk = TRY(read_chunk(layers[number].geometry, ChunkKind::scalars,
                                           static_cast<std::uint8_t>(number), parsed.tag));
  if (chunk.header.entropy != Entropy::none || chunk.header.raw_size != chunk.payload.size() ||
      chunk.header.last_level != svo.depth) {
    return fail("chunk header has a field out of range");
  }
  std::vector<ScalarStreams> fields = TRY(parse_scalars(chunk.payload, number));
  if (!limits.scalar.empty())
    std::erase_if(fields, [&](const ScalarStreams& field) { return field.name != limits.scalar; });
  TRY(budget.take(svo.node_count(), fields.size() * (sizeof(Short4) + 1)));
  TRY(budget.take(svo.internal_count(), fields.size() * 6 * sizeof(Short4)));
  TRY(budget.take(svo.leaf_count(), fields.size() * sizeof(float)));
  return fields;
}

/// Decodes the geometry of the layers that are given. Returns the last level of each.
Result<std::vector<int>> decode_geometry(const std::vector<Chunks<ByteView>>& layers,
                                         const ParsedFrameHeader& frame, const DecodeLimits& limits,
                                         MemoryBudget& budget, Svo& svo) {
  const FrameHeader& header = frame.header;
  GeometryDecoder geometry(header.coded_points, limits.tables);
  std::vector<int> last_levels;
  for (int layer = 0; layer < header.layers; ++layer) {
    const std::size_t number = static_cast<std::size_t>(layer);
    const ByteView bytes = layer == 0               ? frame.rest
                           : number < layers.size() ? layers[number].geometry
                                                    : ByteView{};
    if (bytes.empty() && layer > 0) break;  // a prefix of the layers is a valid coarser frame
    TRY(check_stopped(limits));
    const ParsedChunk chunk =
        TRY(read_chunk(bytes, ChunkKind::geometry, static_cast<std::uint8_t>(layer), frame.tag));
    const int last_level = last_level_of_layer(layer, header.depth);
    if (chunk.header.last_level != last_level) return fail("layer ends at an unexpected level");
    const int first_level = last_levels.empty() ? 0 : last_levels.back();
    if (layer > 0 && !limits.leaves && first_level >= limits.depth) break;
    TRY(take_geometry(chunk, last_level - first_level, header.coded_points, budget));
    TRY(geometry.decode_layer(chunk, first_level, limits.executor, budget, svo.masks));
    last_levels.push_back(last_level);
  }
  svo.depth = last_levels.back();
  if (svo.depth == header.depth && geometry.level_nodes() != header.coded_points) {
    return fail("the number of leaves disagrees with the header");
  }
  if (!index_svo(svo, header.coded_points > 0)) return fail("the masks do not form an octree");
  return last_levels;
}

Result<OctreeFrame> decode_tree(const std::vector<Chunks<ByteView>>& layers,
                                const DecodeLimits& limits) {
  if (layers.empty()) return fail(ErrorCode::argument, "a frame needs at least its base layer");
  const ParsedFrameHeader parsed = TRY(read_frame_header(layers.front().geometry));
  const FrameHeader& header = parsed.header;
  if (header.codec != Codec::octree) return fail("not an octree frame");
  if (header.layers != layer_count(header.depth) ||
      (header.coded_points == 0 && header.depth != 0) ||
      (header.colors_transformed && !header.has_colors) ||
      (header.normals_transformed && !header.has_normals)) {
    return fail("frame header has a field out of range");
  }
  if (header.coded_points > limits.max_points) {
    return fail(ErrorCode::limit, concat("frame has ", header.coded_points,
                                         " points, more than the ", limits.max_points, " allowed"));
  }

  OctreeFrame frame;
  frame.header = header;
  frame.svo.cube = header.cube;
  MemoryBudget budget(limits.max_memory);
  const std::vector<int> last_levels =
      TRY(decode_geometry(layers, parsed, limits, budget, frame.svo));
  if (limits.leaves) TRY(budget.take(frame.svo.leaf_count(), 2 * sizeof(glm::vec3)));
  TRY(take_attribute(frame.svo, layers.front().colors, header.colors_transformed, limits, budget));
  TRY(take_attribute(frame.svo, layers.front().normals, header.normals_transformed, limits,
                     budget));
  const std::vector<ScalarStreams> scalars =
      TRY(at_place("scalar fields", find_scalars(layers, parsed, frame.svo, limits, budget)));
  const bool transformed = (header.colors_transformed && !layers.front().colors.empty()) ||
                           (header.normals_transformed && !layers.front().normals.empty()) ||
                           !scalars.empty();
  if (transformed) TRY(budget.take(frame.svo.internal_count(), 48));  // what both know of the tree

  const int depth = limits.leaves ? kMaxDepth : std::max(limits.depth, 0);
  AttributeDecoder colors(ChunkKind::colors, color_shape(header));
  AttributeDecoder normals(ChunkKind::normals, kNormalShape);
  for (std::size_t layer = 0; layer < last_levels.size(); ++layer) {
    const int number = static_cast<int>(layer), level = last_levels[layer];
    const Chunks<ByteView>& chunks = layers[layer];
    if (header.has_colors && !header.colors_transformed) {
      TRY(at_place("colors",
                   colors.decode_layer(frame.svo, chunks.colors, number, level, parsed.tag)));
    }
    if (header.has_normals && !header.normals_transformed) {
      TRY(at_place("normals",
                   normals.decode_layer(frame.svo, chunks.normals, number, level, parsed.tag)));
    }
  }
  frame.colors = colors_from_codes(colors.codes(), color_shape(header).bits);
  frame.normals = normals_from_codes(normals.codes());
  // They need only the tree, not each other, and so can run in parallel.
  if (transformed) {
    const FrameStructure structure = structure_for(frame.svo, last_levels, header, layers, scalars);
    frame.scalars.resize(scalars.size());
    std::vector<Result<void>> results(2 + scalars.size());
    for_each(limits.executor, static_cast<int>(results.size()), [&](int i) {
      const auto number = static_cast<std::size_t>(i);
      results[number] = i == 0   ? decode_colors(structure, layers, depth, parsed, limits, frame)
                        : i == 1 ? decode_normals(structure, layers, depth, parsed, limits, frame)
                                 : decode_scalars(structure, scalars[number - 2], limits,
                                                  frame.scalars[number - 2]);
    });
    for (const Result<void>& done : results) TRY(done);
  }
  if (limits.inner_nodes) add_means(frame, limits.executor);
  if (depth < frame.svo.depth) cut_off(frame, depth);
  return frame;
}

Result<DecodedFrame> decode(const std::vector<Chunks<ByteView>>& layers,
                            const DecodeLimits& limits) {
  OctreeFrame tree = TRY(decode_tree(layers, limits));
  DecodedFrame frame;
  frame.cube = tree.header.cube;
  frame.depth = tree.header.depth;
  frame.source_points = tree.header.source_points;
  if (limits.leaves) {
    frame.cloud = leaf_centers(tree.svo);
    frame.cloud.colors = std::move(tree.colors);
    frame.cloud.normals = std::move(tree.normals);
    frame.cloud.scalars = std::move(tree.scalars);
  } else {
    frame.scalars = std::move(tree.scalars);
  }
  frame.attributes = std::move(tree.nodes);
  frame.svo = std::move(tree.svo);
  return frame;
}

}  // namespace

Result<OctreeFrame> decode_octree_tree(const std::vector<Chunks<ByteView>>& layers,
                                       const DecodeLimits& limits) {
  return or_out_of_memory([&] { return decode_tree(layers, limits); });
}

Result<DecodedFrame> decode_octree(const std::vector<Chunks<ByteView>>& layers,
                                   const DecodeLimits& limits) {
  return or_out_of_memory([&] { return decode(layers, limits); });
}

}  // namespace pointreel
