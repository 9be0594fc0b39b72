#include "codec/octree/attribute_coder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "codec/octree/coefficient_quantizer.h"
#include "codec/octree/raht.h"
#include "codec/octree/tangent_frame.h"
#include "common/base/byte_io.h"

namespace pointreel {
namespace {

/// No coefficient stands for a larger difference, whatever the bytes say.
constexpr std::int32_t kMostDifference = 65536;

std::int32_t dequantized(std::int32_t magnitude, std::int32_t step) {
  return static_cast<std::int32_t>(
      std::min<std::int64_t>((std::int64_t{magnitude} * step + 128) >> 8, kMostDifference));
}

/// The values that are encoded, of inner nodes and leaves.
struct SourceValues {
  const std::vector<Short4>& inner;
  const std::vector<Short4>& leaves;

  /// The values of a node and of those that follow it on its level.
  const Short4* at(std::uint32_t node) const {
    return node < inner.size() ? inner.data() + node : leaves.data() + (node - inner.size());
  }
};

/// What a layer's header says, and what follows from it.
struct LayerRules {
  AttributeKind kind = AttributeKind::colors;
  bool exact = false;
  ComponentSteps steps{};
  PredictionRule prediction;

  LayerRules(AttributeKind kind_of_layer, bool is_exact, const CoefficientSteps& of_layer)
      : kind(kind_of_layer), exact(is_exact) {
    const std::uint32_t first = of_layer.luma, second = of_layer.chroma;
    const bool normals = kind == AttributeKind::normals;
    steps = {first, normals ? first : second, second};
    prediction = {of_layer.luma / 4, normals};
  }
};

/// The signs of a triple are bits, of which those of a pattern are moved together, and back.
struct SignPlaces {
  std::uint8_t together[8][8], apart[8][8];
};
constexpr SignPlaces kSignPlaces = [] {
  SignPlaces places{};
  for (unsigned pattern = 0; pattern < 8; ++pattern) {
    for (unsigned signs = 0; signs < 8; ++signs) {
      unsigned count = 0, together = 0, apart = 0;
      for (unsigned k = 0; k < 3; ++k) {
        if ((pattern >> k & 1) == 0) continue;
        together |= (signs >> k & 1) << count;
        apart |= (signs >> count & 1) << k;
        ++count;
      }
      places.together[pattern][signs] = static_cast<std::uint8_t>(together);
      places.apart[pattern][signs] = static_cast<std::uint8_t>(apart);
    }
  }
  return places;
}();

/// Encodes or decodes the levels of a layer.
template <class Coder>
class LayerCoder {
 public:
  /// `source`: for encoders.
  LayerCoder(const FrameStructure& structure, const LayerRules& rules,
             CoefficientContexts& contexts, Coder& coder, const SourceValues* source,
             Short4* values, std::vector<Short4>& planes)
      : structure_(structure),
        svo_(structure.svo()),
        rules_(rules),
        scales_(pair_scales()),
        one_(scales_(1, 1)),
        steps_(rules.steps),
        contexts_(contexts),
        coder_(coder),
        source_(source),
        values_(values),
        planes_(planes) {}

  /// Codes the children of a level's nodes. Encoders choose whether to predict them.
  bool code_level(int level, bool predicts) {
    weights_ = structure_.has_unit_children(level) ? nullptr : structure_.weights();
    if constexpr (Coder::kEncodes) predicts = prediction_pays(level);
    if (predicts) {
      around_.resize(svo_.node_count(level));
      LevelPredictor(structure_, level, rules_.prediction, values_, around_.data(), planes_).run();
      code_nodes_of_kind<true>(level);
    } else {
      inherit_values(svo_, level, values_);
      code_nodes_of_kind<false>(level);
    }
    return predicts;
  }

 private:
  /// What is known of a node before its coefficients.
  struct Node {
    std::uint32_t number, first;
    std::uint8_t mask;
    const MergeOrder& order;
    NodeContext context;
  };

  template <bool kPredicts>
  void code_nodes_of_kind(int level) {
    if (rules_.kind == AttributeKind::normals) {
      code_nodes<kPredicts, true>(level);
    } else {
      code_nodes<kPredicts, false>(level);
    }
  }

  template <bool kPredicts, bool kNormals>
  [[gnu::noinline]] void code_nodes(int level) {
    // A copy of a decoder can be kept in registers.
    std::conditional_t<Coder::kEncodes, Coder&, Coder> coder = coder_;
    const std::uint32_t first_node = svo_.level_begin[static_cast<std::size_t>(level)];
    RecentActivity recent;
    for (const std::uint32_t number : structure_.level(level).branching) {
      std::size_t around, activity;
      if constexpr (kPredicts) {
        around = around_[number - first_node];
        activity = around % kActivityClasses;
      } else {
        around = activity = own_activity_class(values_[number]);
      }
      const std::uint8_t mask = svo_.masks[number];
      const Node node{number,
                      svo_.first_child[number],
                      mask,
                      kMergeOrders[mask],
                      {around, activity, recent.context()}};
      recent.add(code_node<kPredicts, kNormals>(coder, node));
    }
    if constexpr (!Coder::kEncodes) coder_ = coder;
  }

  /// Returns the activity of the node's children.
  template <bool kPredicts, bool kNormals, class C>
  [[gnu::always_inline]] inline std::int32_t code_node(C& coder, const Node& node) {
    const int pairs = node.order.pairs;
    std::array<Triple, 7> q;
    unsigned coded = 0, pattern = 0;
    if constexpr (Coder::kEncodes) {
      if (find_coefficients(node, q)) {
        for (int i = 0; i < pairs; ++i) {
          coded |= (is_zero(q[static_cast<std::size_t>(pairs - 1 - i)]) ? 0u : 1u) << i;
        }
        pattern = pattern_of(q[0]);
      }
    }
    coded = code_pairs(coder, contexts_, node.context, pairs, coded, pattern);
    if (!kNormals && rules_.exact) return code_exactly<kPredicts>(coder, node, coded, pattern, q);
    if (coded == 0) return 0;
    std::int32_t sum = 0;
    if (pairs == 1) {
      // More than half of those that are coded.
      const PairScale scale =
          weights_ == nullptr ? one_ : scales_(weights_[node.first], weights_[node.first + 1]);
      Int4 difference = code_triple<kNormals>(coder, node, pattern, q[0], &scale, sum);
      if constexpr (kNormals) {
        difference = TangentFrame(load(values_[node.number])).reflect(difference);
      }
      const std::int32_t activity = activity_for(sum, pairs);
      const Int4 offset = mean_offset(difference, scale.ratio);
      add(node.first, -offset, activity);
      add(node.first + 1, difference - offset, activity);
      return activity;
    }
    NodeScales found;
    const NodeScales& scales = scales_of(node, found);
    std::array<Int4, 7> differences{};
    const bool several = (coded & (coded - 1)) != 0;
    for (unsigned rest = coded; rest != 0; rest &= rest - 1) {
      const auto i = static_cast<std::size_t>(pairs - 1 - std::countr_zero(rest));
      pattern = code_pattern(coder, node, several, q[i]);
      differences[i] = code_triple<kNormals>(coder, node, pattern, q[i], &scales[i], sum);
    }
    if constexpr (kNormals) {
      const TangentFrame frame(load(values_[node.number]));
      for (unsigned rest = coded; rest != 0; rest &= rest - 1) {
        const auto i = static_cast<std::size_t>(pairs - 1 - std::countr_zero(rest));
        differences[i] = frame.reflect(differences[i]);
      }
    }
    const std::int32_t activity = activity_for(sum, pairs);
    std::array<Int4, 8> values;
    values[0] = Int4{};
    split(node.order, scales, values.data(), differences.data());
    for (std::uint32_t c = 0; c <= node.order.pairs; ++c) {
      add(node.first + c, values[c], activity);
    }
    return activity;
  }

  /// Coefficients of exact layers are differences of the children's own values less the expected
  /// ones, which are undone in integers without a loss.
  template <bool kPredicts, class C>
  [[gnu::noinline]] std::int32_t code_exactly(C& coder, const Node& node, unsigned coded,
                                              unsigned pattern, std::array<Triple, 7>& q) {
    NodeScales found;
    const NodeScales& scales = scales_of(node, found);
    std::array<Int4, 7> differences{};
    const std::size_t pairs = node.order.pairs;
    if (kPredicts) find_expected(node, scales, differences.data());
    std::int32_t sum = 0;
    const bool several = (coded & (coded - 1)) != 0;
    for (unsigned rest = coded; rest != 0; rest &= rest - 1) {
      const std::size_t i = pairs - 1 - static_cast<std::size_t>(std::countr_zero(rest));
      if (pairs > 1) pattern = code_pattern(coder, node, several, q[i]);
      const Int4 d = code_triple<false>(coder, node, pattern, q[i], nullptr, sum);
      differences[i] = clamp(differences[i] + d, -kMostDifference, kMostDifference);
    }
    const std::int32_t activity = activity_for(sum, static_cast<int>(pairs));
    std::array<Int4, 8> values;
    values[0] = load(values_[node.number]) & kComponents;
    split(node.order, scales, values.data(), differences.data());
    for (std::uint32_t c = 0; c <= node.order.pairs; ++c) {
      values_[node.first + c] = stored_value((values[c] & kComponents) + fourth_lane(activity));
    }
    return activity;
  }

  const NodeScales& scales_of(const Node& node, NodeScales& found) const {
    if (weights_ == nullptr) return unit_scales(node.mask);
    find_scales(scales_, node.order, weights_ + node.first, found);
    return found;
  }

  template <class C>
  unsigned code_pattern(C& coder, const Node& node, bool several, const Triple& q) {
    const unsigned pattern = Coder::kEncodes ? pattern_of(q) : 0;
    Alphabet8& alphabet =
        contexts_.pattern[node.context.activity][node.context.recent][several ? 1 : 0];
    return static_cast<unsigned>(coder.code(0, alphabet, static_cast<int>(pattern)));
  }

  /// Codes what a pattern says of a triple. Returns the difference that it stands for: with a
  /// scale, in steps. Adds to `sum` how much there was to code.
  template <bool kNormals, class C>
  [[gnu::always_inline]] inline Int4 code_triple(C& coder, const Node& node, unsigned pattern,
                                                 const Triple& q, const PairScale* scale,
                                                 std::int32_t& sum) {
    unsigned signs = 0;
    if constexpr (Coder::kEncodes) {
      signs = (q[0] < 0 ? 1u : 0u) | (q[1] < 0 ? 2u : 0u) | (q[2] < 0 ? 4u : 0u);
    }
    const bool several = (pattern & (pattern - 1)) != 0;
    if (several && !kNormals) {
      // The signs of luma and chroma often go together.
      signs =
          static_cast<unsigned>(coder.code(1, contexts_.signs[pattern], static_cast<int>(signs)));
    } else {
      signs = kSignPlaces.apart[pattern][coder.bits(std::popcount(pattern),
                                                    kSignPlaces.together[pattern][signs])];
    }
    // One pass for each bit of the pattern is mispredicted less often than a branch for each
    // component.
    std::array<std::int32_t, 4> difference{};
    const Int4 steps = scale == nullptr ? Int4{} : steps_(*scale);
    for (unsigned rest = pattern; rest != 0; rest &= rest - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(rest));
      const std::int32_t magnitude = code_magnitude(coder, contexts_, k, node.context.activity,
                                                    several, Coder::kEncodes ? std::abs(q[k]) : 0);
      sum += magnitude << (k == 0 || (k == 1 && kNormals) ? 1 : 0);
      const std::int32_t size =
          scale == nullptr ? magnitude : dequantized(magnitude, steps[static_cast<int>(k)]);
      const std::int32_t negative = -static_cast<std::int32_t>(signs >> k & 1);
      difference[k] = (size ^ negative) - negative;
    }
    return Int4{difference[0], difference[1], difference[2], 0};
  }

  /// The differences of the base values.
  void find_expected(const Node& node, const NodeScales& scales, Int4* expected) const {
    std::array<Int4, 8> values;
    for (std::size_t c = 0; c <= node.order.pairs; ++c) {
      values[c] = load(values_[node.first + c]) & kComponents;
    }
    merge(node.order, scales, values.data(), expected);
  }

  /// How much there was to code in a node, 0 to kMostActivity. Exact layers code much more.
  std::int32_t activity_for(std::int32_t sum, int pairs) const {
    // 2^16 / pairs, rounded up, which gives exact quotients of small numbers.
    constexpr std::int32_t kReciprocals[8] = {0, 65536, 32768, 21846, 16384, 13108, 10923, 9363};
    const std::int32_t amount = rules_.exact ? std::min(sum, 1024) : 4 * std::min(sum, 256);
    return std::min((amount * kReciprocals[pairs]) >> 16, kMostActivity);
  }

  [[gnu::always_inline]] void add(std::uint32_t node, const Int4& difference,
                                  std::int32_t activity) {
    const Int4 value = (load(values_[node]) + difference) & kComponents;
    values_[node] = stored_value(value + fourth_lane(activity));
  }

  // For encoders.

  /// The coefficients of a node. Returns false if all of them are zero; q is then unspecified.
  bool find_coefficients(const Node& node, std::array<Triple, 7>& q) const {
    NodeScales found;
    const NodeScales& scales = scales_of(node, found);
    std::array<Int4, 8> values;
    std::array<Int4, 7> differences;
    const Short4* const source = source_->at(node.first);
    for (std::size_t c = 0; c <= node.order.pairs; ++c) {
      values[c] = load(source[c]) & kComponents;
      if (!rules_.exact) values[c] -= load(values_[node.first + c]) & kComponents;
    }
    merge(node.order, scales, values.data(), differences.data());
    if (rules_.exact) {
      std::array<Int4, 7> expected;
      find_expected(node, scales, expected.data());
      bool any = false;
      for (std::size_t i = 0; i < node.order.pairs; ++i) {
        const Int4 d = differences[i] - expected[i];
        q[i] = {d[0], d[1], d[2]};
        any |= !is_zero(q[i]);
      }
      return any;
    }
    if (rules_.kind == AttributeKind::normals) {
      // The frame keeps lengths, and the first step is the smallest.
      if (are_short(node.order.pairs, scales, steps_, differences.data())) return false;
      const TangentFrame frame(load(values_[node.number]));
      for (std::size_t i = 0; i < node.order.pairs; ++i) {
        differences[i] = frame.reflect(differences[i]);
      }
    }
    return quantize_node(node.order.pairs, scales, steps_, differences.data(), contexts_,
                         node.context, q);
  }

  /// Prediction takes time, so it must make the differences between children smaller by a
  /// twentieth. This is estimated from some slices.
  bool prediction_pays(int level) {
    const LevelStructure& of_level = structure_.level(level);
    if (!of_level.predictable) return false;
    const int components = rules_.prediction.all_components ? 3 : 1;
    const std::size_t every = of_level.by_z.slices.size() < 64 ? 2 : 8;
    std::int64_t without = 0, with = 0;
    around_.resize(svo_.node_count(level));
    LevelPredictor(structure_, level, rules_.prediction, values_, around_.data(), planes_)
        .run_some(every, [&](const BranchingNode& node) {
          const Short4* const source = source_->at(node.first_child);
          const Short4* const expected = values_ + node.first_child;
          for (int c = 1; c < std::popcount(node.mask); ++c) {
            for (int k = 0; k < components; ++k) {
              const std::int32_t d = source[c].lanes[k] - source[0].lanes[k];
              without += std::abs(d);
              with += std::abs(d - (expected[c].lanes[k] - expected[0].lanes[k]));
            }
          }
        });
    return 20 * with < 19 * without;
  }

  const FrameStructure& structure_;
  const Svo& svo_;
  const LayerRules& rules_;
  const PairScales& scales_;
  const PairScale one_;  ///< of two nodes that weigh 1
  const PairSteps steps_;
  CoefficientContexts& contexts_;
  Coder& coder_;
  const SourceValues* source_;
  Short4* values_;
  std::vector<Short4>& planes_;
  std::vector<std::uint8_t> around_;
  const std::uint32_t* weights_ = nullptr;
};

/// The flags of a layer: one bit for each of its levels whose children are predicted, and one for
/// exact layers.
constexpr unsigned kExactFlag = 0x8000;

/// Computes the means of the inner nodes. They need not be exact, since a deviation from the
/// transform's own mean is coded with the children.
void fill_means(const FrameStructure& structure, const SourceValues& source,
                std::vector<Short4>& means) {
  const Svo& svo = structure.svo();
  for (int level = svo.depth; level-- > 0;) {
    const std::size_t l = static_cast<std::size_t>(level);
    const bool unit = structure.has_unit_children(level);
    for (std::uint32_t node = svo.level_begin[l]; node < svo.level_begin[l + 1]; ++node) {
      const std::uint32_t first = svo.first_child[node];
      const int children = std::popcount(svo.masks[node]);
      const Short4* const child = source.at(first);
      if (children == 1) {
        means[node] = child[0];
        continue;
      }
      typedef float Float4 __attribute__((vector_size(16)));
      Float4 sum{};
      float weight = 0.0f;
      for (int c = 0; c < children; ++c) {
        const float w =
            unit ? 1.0f
                 : static_cast<float>(structure.weights()[first + static_cast<std::uint32_t>(c)]);
        sum += __builtin_convertvector(load(child[c]), Float4) * w;
        weight += w;
      }
      means[node] = narrow(__builtin_convertvector(sum / weight + 32768.5f, Int4) - 32768);
      means[node].lanes[3] = 1;
    }
  }
}

/// Computes the means that an exact layer is undone from: those that merging gives, in integers.
void fill_merged(const FrameStructure& structure, const SourceValues& source,
                 std::vector<Short4>& means) {
  const Svo& svo = structure.svo();
  for (int level = svo.depth; level-- > 0;) {
    const std::size_t l = static_cast<std::size_t>(level);
    const bool unit = structure.has_unit_children(level);
    for (std::uint32_t node = svo.level_begin[l]; node < svo.level_begin[l + 1]; ++node) {
      const std::uint32_t first = svo.first_child[node];
      const MergeOrder& order = kMergeOrders[svo.masks[node]];
      NodeScales found;
      if (!unit) find_scales(pair_scales(), order, structure.weights() + first, found);
      const NodeScales& scales = unit ? unit_scales(svo.masks[node]) : found;
      const Short4* const child = source.at(first);
      std::array<Int4, 8> values;
      std::array<Int4, 7> differences;
      for (std::size_t c = 0; c <= order.pairs; ++c) values[c] = load(child[c]) & kComponents;
      merge(order, scales, values.data(), differences.data());
      means[node] = stored_value((values[0] & kComponents) + fourth_lane(0));
    }
  }
}

}  // namespace

TransformEncoder::TransformEncoder(const FrameStructure& structure, AttributeKind kind,
                                   const std::vector<Short4>& leaves, bool exact)
    : structure_(structure),
      kind_(kind),
      leaves_(leaves),
      exact_(exact),
      means_(structure.svo().internal_count()),
      decoded_(structure.svo().node_count() + kRoomForValues) {
  (exact ? fill_merged : fill_means)(structure, {means_, leaves_}, means_);
}

Bytes TransformEncoder::encode_layer(const CoefficientSteps& steps) {
  const std::vector<int>& ends = structure_.layer_ends();
  const int first_level = layer_ == 0 ? 0 : ends[layer_ - 1], last_level = ends[layer_];
  const SourceValues source{means_, leaves_};
  const LayerRules rules(kind_, exact_, steps);
  if (layer_ == 0 && structure_.svo().node_count() > 0) {
    decoded_[0] = stored_value((load(*source.at(0)) & kComponents) + fourth_lane(0));
  }
  SymbolEncoder coder;
  LayerCoder<SymbolEncoder> layer(structure_, rules, contexts_, coder, &source, decoded_.data(),
                                  planes_);
  unsigned flags = exact_ ? kExactFlag : 0;
  for (int level = first_level; level < last_level; ++level) {
    if (layer.code_level(level, false)) flags |= 1u << (level - first_level);
  }
  Bytes out;
  ByteWriter writer(out);
  writer.put(static_cast<std::uint16_t>(flags));
  writer.put(steps.luma);
  writer.put(steps.chroma);
  if (layer_ == 0 && structure_.svo().node_count() > 0) {
    for (int k = 0; k < 3; ++k) writer.put(decoded_[0].lanes[k]);
  }
  coder.finish(out);
  ++layer_;
  return out;
}

LevelSet TransformDecoder::predicted_levels(ByteView bytes, int first_level) {
  const LevelSet flags = ByteReader(bytes).get<std::uint16_t>() & ~kExactFlag;
  return flags << first_level;
}

TransformDecoder::TransformDecoder(const FrameStructure& structure, AttributeKind kind)
    : structure_(structure),
      kind_(kind),
      decoded_(std::make_unique_for_overwrite<Short4[]>(structure.svo().node_count() +
                                                        kRoomForValues)) {}

Result<void> TransformDecoder::decode_layer(ByteView bytes, int last_level, int stop) {
  ByteReader reader(bytes);
  const auto flags = reader.get<std::uint16_t>();
  CoefficientSteps steps;
  steps.luma = reader.get<std::uint16_t>();
  steps.chroma = reader.get<std::uint16_t>();
  if (level_ == 0 && structure_.svo().node_count() > 0) {
    Int4 root = {};
    for (int k = 0; k < 3; ++k) root[k] = reader.get<std::int16_t>();
    decoded_[0] = stored_value(root + fourth_lane(0));
  }
  const bool exact = (flags & kExactFlag) != 0;
  if (level_ == 0) exact_ = exact;
  if (!reader.ok() || exact != exact_ || (exact && kind_ != AttributeKind::colors) ||
      steps.luma == 0 || steps.chroma == 0) {
    return fail("a field is out of range");
  }
  for (int bit = 0; bit < 15; ++bit) {
    if ((flags >> bit & 1) == 0) continue;
    const int level = level_ + bit;
    if (level >= last_level || !structure_.level(level).predictable) {
      return fail("a level that cannot be predicted is");
    }
  }
  const LayerRules rules(kind_, exact, steps);
  SymbolDecoder coder(reader.rest());
  LayerCoder<SymbolDecoder> layer(structure_, rules, contexts_, coder, nullptr, decoded_.get(),
                                  planes_);
  const int end = std::min(last_level, stop);
  for (int level = level_; level < end; ++level) {
    layer.code_level(level, (flags >> (level - level_) & 1) != 0);
  }
  if (stop >= last_level && !coder.complete()) return fail("the bytes do not fit the tree");
  level_ = std::max(level_, end);
  return {};
}

void TransformDecoder::inherit(int last_level) {
  for (; level_ < last_level; ++level_) {
    inherit_values(structure_.svo(), level_, decoded_.get());
  }
}

std::span<const Short4> TransformDecoder::values(int level) const {
  const Svo& svo = structure_.svo();
  return {decoded_.get() + svo.level_begin[static_cast<std::size_t>(level)], svo.node_count(level)};
}

std::span<const Short4> TransformDecoder::values() const {
  return {decoded_.get(), structure_.svo().level_begin[static_cast<std::size_t>(level_) + 1]};
}

namespace {

/// The step for a quality, in units of CoefficientSteps.
std::uint32_t coefficient_step(int quality) {
  // 256 * 2^(i / 14), rounded.
  constexpr std::array<std::uint32_t, 14> kFractions = {256, 269, 283, 297, 312, 328, 345,
                                                        362, 380, 400, 420, 441, 464, 487};
  const auto below = static_cast<std::uint32_t>(99 - quality);
  return kFractions[below % 14] << below / 14;
}

CoefficientSteps limited(std::uint32_t luma, std::uint32_t chroma) {
  return {static_cast<std::uint16_t>(std::min(luma, 65535u)),
          static_cast<std::uint16_t>(std::min(chroma, 65535u))};
}

}  // namespace

CoefficientSteps color_steps(int quality) {
  const std::uint32_t step = coefficient_step(quality);
  return limited(step, step * 2);
}

CoefficientSteps normal_steps(int quality) {
  const std::uint32_t step = coefficient_step(quality) * 15 / 16;
  return limited(step, step * 2);
}

CoefficientSteps layer_steps(const CoefficientSteps& steps, std::uint32_t leaves,
                             std::uint32_t nodes) {
  const auto scaled = [&](std::uint64_t step) {
    // Computes twice the step, so that it can be rounded to nearest.
    const std::uint32_t twice = square_root(4 * step * step * nodes / leaves);
    return static_cast<std::uint16_t>(std::max((twice + 1) / 2, 1u));
  };
  return {scaled(steps.luma), scaled(steps.chroma)};
}

}  // namespace pointreel
