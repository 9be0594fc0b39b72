#include "codec/octree/attribute_coder.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "codec/octree/coefficient_coder.h"
#include "codec/octree/coefficient_quantizer.h"
#include "codec/octree/raht.h"
#include "common/base/byte_io.h"
#include "pointreel/octree.h"

namespace pointreel {
namespace {

/// The weights of the nodes of a layer: the number of their descendants at the layer's last level,
/// at most 2^26.
class Weights {
 public:
  Weights(const Svo& svo, int first_level, int last_level)
      : begin_(svo.level_begin[static_cast<std::size_t>(first_level)]),
        end_(svo.level_begin[static_cast<std::size_t>(last_level)]),
        weights_(end_ - begin_) {
    for (std::uint32_t node = end_; node-- > begin_;) {
      const std::uint32_t first = svo.first_child[node];
      const auto children = static_cast<std::uint32_t>(std::popcount(svo.masks[node]));
      std::uint32_t sum = children;
      if (first < end_) {
        sum = 0;
        for (std::uint32_t child = first; child < first + children; ++child) {
          sum += weights_[child - begin_];
        }
      }
      weights_[node - begin_] = std::min(sum, std::uint32_t{1} << 26);
    }
  }

  std::uint32_t operator[](std::uint32_t node) const {
    return node < end_ ? weights_[node - begin_] : 1;
  }

 private:
  std::uint32_t begin_, end_;
  std::vector<std::uint32_t> weights_;
};

/// Finds the scales of the pairs of nodes in a layer.
class Scales {
 public:
  Scales(const Svo& svo, const Weights& weights, const CoefficientSteps& steps)
      : svo_(svo), weights_(weights), table_(steps.luma, steps.chroma), of_units_(256) {
    for (std::size_t mask = 1; mask < 256; ++mask) {
      const MergeOrder& order = kMergeOrders[mask];
      for (std::size_t i = 0; i < order.pairs; ++i) {
        const auto [w0, w1] = order.unit_weights[i];
        of_units_[mask].pair[i] = &table_(w0, w1, of_units_[mask].made[i]);
      }
      find_least_steps(order, of_units_[mask]);
    }
  }

  /// `unit`: whether the node's children are at the layer's last level, where all weigh 1.
  const NodeScales& operator()(std::uint32_t node, bool unit) {
    const std::uint8_t mask = svo_.masks[node];
    if (unit) return of_units_[mask];
    const MergeOrder& order = kMergeOrders[mask];
    std::array<std::uint32_t, 8> weight;
    for (std::uint32_t c = 0; c <= order.pairs; ++c) {
      weight[c] = weights_[svo_.first_child[node] + c];
    }
    for (std::size_t i = 0; i < order.pairs; ++i) {
      const auto [first, second] = order.pair[i];
      found_.pair[i] = &table_(weight[first], weight[second], found_.made[i]);
      weight[first] += weight[second];
    }
    find_least_steps(order, found_);
    return found_;
  }

 private:
  static void find_least_steps(const MergeOrder& order, NodeScales& scales) {
    scales.least_steps = broadcast(std::numeric_limits<std::int32_t>::max());
    for (std::size_t i = 0; i < order.pairs; ++i) {
      scales.least_steps = min(scales.least_steps, scales.pair[i]->steps);
    }
  }

  const Svo& svo_;
  const Weights& weights_;
  PairScales table_;
  std::vector<NodeScales> of_units_;  ///< by mask, where all children weigh 1
  NodeScales found_;
};

/// No difference is larger, whatever the bytes say.
constexpr std::int32_t kMostDifference = 65536;

std::int32_t dequantize(std::int32_t q, std::int32_t step) {
  const std::int64_t magnitude = (std::int64_t{std::abs(q)} * step + 128) >> 8;
  const auto bounded =
      static_cast<std::int32_t>(std::min<std::int64_t>(magnitude, kMostDifference));
  return q < 0 ? -bounded : bounded;
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

/// Encodes or decodes the levels of a layer. The encoder does not compute decoded leaves.
template <class Coder>
class LayerCoder {
 public:
  LayerCoder(const Svo& svo, int first_level, int last_level, const CoefficientSteps& steps,
             Neighborhoods* neighborhoods, CoefficientContexts& contexts, Coder& coder,
             const SourceValues* source, Short4* decoded, bool exact)
      : svo_(svo),
        first_level_(first_level),
        last_level_(last_level),
        weights_(svo, first_level, last_level),
        scales_(svo, weights_, steps),
        luma_step_(steps.luma / 4),
        neighborhoods_(neighborhoods),
        contexts_(contexts),
        coder_(coder),
        source_(source),
        decoded_(decoded),
        exact_(exact) {}

  /// Codes up to the layer's last level, or up to `stop`.
  void run(int stop = kMaxDepth) {
    for (int level = first_level_; level < std::min(last_level_, stop); ++level) {
      unit_ = level == last_level_ - 1;
      decodes_ = !Coder::kEncodes || level < svo_.depth - 1;
      if (neighborhoods_ != nullptr && level > 0) {
        predicted_level(level);
      } else {
        const std::size_t l = static_cast<std::size_t>(level);
        for (std::uint32_t node = svo_.level_begin[l]; node < svo_.level_begin[l + 1]; ++node) {
          code_node<false>(node, 0);
        }
      }
    }
  }

 private:
  void predicted_level(int level) {
    while (neighborhoods_->level() < level - 1) neighborhoods_->descend();
    neighborhoods_->set_values(decoded_);
    const std::size_t l = static_cast<std::size_t>(level);
    for (std::uint32_t above = svo_.level_begin[l - 1]; above < svo_.level_begin[l]; ++above) {
      neighborhoods_->load(above, block_);
      std::uint32_t node = svo_.first_child[above];
      for (unsigned mask = svo_.masks[above]; mask != 0; mask &= mask - 1, ++node) {
        const int octant = std::countr_zero(mask);
        code_node<true>(node, ValueBlock::cell(octant));
        neighborhoods_->set_value(above, octant, decoded_[node]);
      }
    }
  }

  template <bool kPredicts>
  void code_node(std::uint32_t node, int cell) {
    const unsigned mask = svo_.masks[node];
    const MergeOrder& order = kMergeOrders[mask];
    const std::uint32_t first = svo_.first_child[node];
    if (order.pairs == 0) {
      if (decodes_) decoded_[first] = decoded_[node];
      return;
    }
    const std::size_t children = std::size_t{order.pairs} + 1;
    const NodeScales& scales = scales_(node, unit_);

    std::array<Int4, 8> expected;
    const Int4 own = load(decoded_[node]) & kComponents;
    Int4 mean = own;
    int gradient = 0;
    std::int32_t weight = kPredicts ? 0 : 1;
    std::int32_t near_activity = kPredicts ? 0 : last_activity_;
    if constexpr (kPredicts) {
      unsigned octants = mask;
      Int4 least = mean, most = mean;
      std::array<Int4, 8> merged;
      for (std::size_t c = 0; c < children; ++c, octants &= octants - 1) {
        const Int4 value = block_.predict(cell, std::countr_zero(octants), weight, near_activity);
        expected[c] = merged[c] = value;
        least = min(least, value);
        most = max(most, value);
      }
      merge(order, scales, merged.data(), expected_differences_.data());
      mean -= merged[0];
      gradient = gradient_class(most[0] - least[0]);
    }

    const int activity = activity_class(near_activity, weight);
    std::array<Triple, 7> q;
    bool coded = false;
    if constexpr (Coder::kEncodes) {
      std::array<Int4, 8> residuals;
      const Short4* source = source_->at(first);
      for (std::size_t c = 0; c < children; ++c) {
        residuals[c] = load(source[c]);
        if (kPredicts && !exact_) residuals[c] -= expected[c];
      }
      coded = exact_ ? exact_coefficients<kPredicts>(order, scales, residuals, q)
                     : quantize_node(order, scales, residuals, contexts_, gradient, activity, q);
    }
    coded = code_coefficients<kPredicts>(order, gradient, activity, coded, q);
    last_activity_ = coded ? activity_of(order, q) : 0;
    const Int4 fourth = fourth_lane(last_activity_);
    if constexpr (kPredicts) {
      decoded_[node] = narrow(own | fourth);
      block_.values[static_cast<std::size_t>(cell)] = decoded_[node];
    }

    if (!decodes_) return;
    if (exact_) return decode_exactly<kPredicts>(order, scales, own, coded ? &q : nullptr, first);
    if (!coded) {
      for (std::size_t c = 0; c < children; ++c) {
        if constexpr (kPredicts) {
          decoded_[first + c] = stored_value((mean + expected[c]) | fourth);
        } else {
          decoded_[first + c] = stored_value(mean | fourth);
        }
      }
      return;
    }
    std::array<Int4, 7> differences;
    for (std::size_t i = 0; i < order.pairs; ++i) {
      const Int4& steps = scales.pair[i]->steps;
      differences[i] = is_zero(q[i])
                           ? Int4{}
                           : Int4{dequantize(q[i][0], steps[0]), dequantize(q[i][1], steps[1]),
                                  dequantize(q[i][2], steps[2]), 0};
    }
    std::array<Int4, 8> values;
    values[0] = mean;
    split(order, scales, values.data(), differences.data());
    for (std::size_t c = 0; c < children; ++c) {
      if constexpr (kPredicts) values[c] += expected[c];
      decoded_[first + c] = stored_value(values[c] | fourth);
    }
  }

  /// In exact layers coefficients are differences of the children's own values, which are undone in
  /// integers without a loss. Prediction takes the expected differences from them. `values`: those
  /// of the children, overwritten. Returns false if all coefficients are zero.
  template <bool kPredicts>
  bool exact_coefficients(const MergeOrder& order, const NodeScales& scales,
                          std::array<Int4, 8>& values, std::array<Triple, 7>& q) const {
    std::array<Int4, 7> differences;
    merge(order, scales, values.data(), differences.data());
    bool any = false;
    for (std::size_t i = 0; i < order.pairs; ++i) {
      if constexpr (kPredicts) differences[i] -= expected_differences_[i];
      q[i] = {differences[i][0], differences[i][1], differences[i][2]};
      any |= !is_zero(q[i]);
    }
    return any;
  }

  /// Undoes that. `q`: null if all of them are zero.
  template <bool kPredicts>
  void decode_exactly(const MergeOrder& order, const NodeScales& scales, const Int4& own,
                      const std::array<Triple, 7>* q, std::uint32_t first) {
    std::array<Int4, 7> differences;
    for (std::size_t i = 0; i < order.pairs; ++i) {
      Int4 d = {};
      if (q != nullptr) d = Int4{(*q)[i][0], (*q)[i][1], (*q)[i][2], 0};
      if constexpr (kPredicts) d += expected_differences_[i] & kComponents;
      differences[i] = clamp(d, -kMostDifference, kMostDifference);
    }
    std::array<Int4, 8> values;
    values[0] = own;
    split(order, scales, values.data(), differences.data());
    const Int4 fourth = fourth_lane(last_activity_);
    for (std::size_t c = 0; c <= order.pairs; ++c) {
      decoded_[first + c] = stored_value(values[c] | fourth);
    }
  }

  /// The class of how much the expected luma of a node's children varies, relative to the step.
  int gradient_class(std::int32_t range) const {
    return (8 * range >= luma_step_) + (4 * range >= luma_step_) + (2 * range >= luma_step_) +
           (range >= luma_step_);
  }

  /// The class of how much there was to code in the neighbours of a node.
  static int activity_class(std::int32_t activity, std::int32_t weight) {
    if (activity == 0) return 0;
    if (2 * activity < weight) return 1;
    if (activity < weight) return 2;
    if (2 * activity < 5 * weight) return 3;
    if (activity < 6 * weight) return 4;
    return activity < 12 * weight ? 5 : 6;
  }

  /// How much there is to code in a node, 0 to kMostActivity.
  static std::int32_t activity_of(const MergeOrder& order, const std::array<Triple, 7>& q) {
    std::int32_t sum = 0;
    for (std::size_t i = 0; i < order.pairs; ++i) {
      sum += 2 * std::abs(q[i][0]) + std::abs(q[i][1]) + std::abs(q[i][2]);
    }
    return std::min(4 * sum / order.pairs, kMostActivity);
  }

  /// Encodes q, which `any` says is not all zero, or decodes it. Returns false if all of q is zero;
  /// q is then not set.
  template <bool kPredicts>
  bool code_coefficients(const MergeOrder& order, int gradient, int activity, bool any,
                         std::array<Triple, 7>& q) {
    any = coder_.code(contexts_.node[gradient][activity][order.size_class], any) != 0;
    if (!any) return false;
    TripleContext context{gradient, activity};
    for (int i = order.pairs - 1; i >= 0; --i) {
      const auto pair = static_cast<std::size_t>(i);
      if constexpr (kPredicts) {
        for (int k = 0; k < 3; ++k) {
          const std::int32_t d = expected_differences_[pair][k];
          context.expected[static_cast<std::size_t>(k)] = d > 0 ? 1 : d < 0 ? 2 : 0;
        }
      }
      code_triple(coder_, contexts_, context, i > 0 || context.stage > 0, q[pair]);
      context.stage = std::min(context.stage + !is_zero(q[pair]), 2);
      context.place = std::min(context.place + 1, 2);
    }
    return true;
  }

  const Svo& svo_;
  int first_level_, last_level_;
  bool unit_ = false, decodes_ = true;
  Weights weights_;
  Scales scales_;
  std::int32_t luma_step_;
  Neighborhoods* neighborhoods_;
  CoefficientContexts& contexts_;
  Coder& coder_;
  const SourceValues* source_;
  Short4* decoded_;
  bool exact_;
  /// The activity of the node coded last. Contexts depend on it where neighbours are not known.
  std::int32_t last_activity_ = 0;
  ValueBlock block_;
  std::array<Int4, 7> expected_differences_;  ///< for the pairs of the current node
};

constexpr std::uint8_t kPredictionFlag = 1, kExactFlag = 2;

/// Computes the means of the nodes of a layer from those of its last level. They need not be exact,
/// since a deviation from the transform's own mean is coded with the children.
void fill_means(const Svo& svo, int first_level, int last_level, const SourceValues& source,
                std::vector<Short4>& means) {
  const Weights weights(svo, first_level, last_level);
  const std::uint32_t begin = svo.level_begin[static_cast<std::size_t>(first_level)];
  const std::uint32_t end = svo.level_begin[static_cast<std::size_t>(last_level)];
  for (std::uint32_t node = end; node-- > begin;) {
    const std::uint32_t first = svo.first_child[node];
    const auto children = static_cast<std::uint32_t>(std::popcount(svo.masks[node]));
    const Short4* child = source.at(first);
    if (first >= end) {
      Int4 sum = load(*child);
      for (std::uint32_t c = 1; c < children; ++c) sum += load(child[c]);
      const auto reciprocal = static_cast<std::int32_t>(65536 / children);
      means[node] = narrow((sum * reciprocal + (1 << 15)) >> 16);
      continue;
    }
    std::array<std::int64_t, 3> sum{};
    std::int64_t weight = 0;
    for (std::uint32_t c = 0; c < children; ++c) {
      const std::int64_t w = weights[first + c];
      weight += w;
      for (std::size_t k = 0; k < 3; ++k) sum[k] += w * child[c].lanes[k];
    }
    for (std::size_t k = 0; k < 3; ++k) {
      means[node].lanes[k] = static_cast<std::int16_t>(sum[k] / weight);
    }
    means[node].lanes[3] = 1;
  }
}

/// Computes the means that an exact layer is undone from: those that merging gives, in integers.
void fill_merged(const Svo& svo, int first_level, int last_level, const SourceValues& source,
                 std::vector<Short4>& means) {
  const Weights weights(svo, first_level, last_level);
  Scales scales(svo, weights, kExactSteps);
  const std::uint32_t begin = svo.level_begin[static_cast<std::size_t>(first_level)];
  const std::uint32_t end = svo.level_begin[static_cast<std::size_t>(last_level)];
  for (std::uint32_t node = end; node-- > begin;) {
    const std::uint32_t first = svo.first_child[node];
    const MergeOrder& order = kMergeOrders[svo.masks[node]];
    const Short4* child = source.at(first);
    std::array<Int4, 8> values;
    std::array<Int4, 7> differences;
    for (std::size_t c = 0; c <= order.pairs; ++c) values[c] = load(child[c]) & kComponents;
    merge(order, scales(node, first >= end), values.data(), differences.data());
    means[node] = stored_value(values[0] | fourth_lane(0));
  }
}

}  // namespace

TransformEncoder::TransformEncoder(const Svo& svo, const std::vector<Short4>& leaves,
                                   const std::vector<int>& layer_ends, bool exact)
    : svo_(svo),
      leaves_(leaves),
      layer_ends_(layer_ends),
      exact_(exact),
      means_(svo.internal_count()),
      decoded_(svo.internal_count()),
      neighborhoods_(svo) {
  for (std::size_t layer = layer_ends.size(); layer-- > 0;) {
    const auto fill = exact ? fill_merged : fill_means;
    fill(svo, layer == 0 ? 0 : layer_ends[layer - 1], layer_ends[layer], {means_, leaves_}, means_);
  }
}

/// Prediction takes time, so it must make the differences of luma smaller by a twentieth. This is
/// estimated from the children of a few hundred nodes of the level above.
bool TransformEncoder::prediction_pays(int level) {
  while (neighborhoods_.level() < level - 1) neighborhoods_.descend();
  neighborhoods_.set_values(means_.data());
  const std::size_t l = static_cast<std::size_t>(level);
  const std::uint32_t begin = svo_.level_begin[l - 1], end = svo_.level_begin[l];
  const std::uint32_t stride = std::max((end - begin) / 512, 1u);
  std::int64_t without = 0, with = 0;
  ValueBlock block;
  for (std::uint32_t above = begin; above < end; above += stride) {
    neighborhoods_.load(above, block);
    std::uint32_t node = svo_.first_child[above];
    for (unsigned mask = svo_.masks[above]; mask != 0; mask &= mask - 1, ++node) {
      const int cell = ValueBlock::cell(std::countr_zero(mask));
      const Short4* child = SourceValues{means_, leaves_}.at(svo_.first_child[node]);
      std::int32_t first = 0, first_residual = 0, unused = 0;
      for (unsigned octants = svo_.masks[node]; octants != 0; octants &= octants - 1, ++child) {
        const std::int32_t luma = child->lanes[0];
        const std::int32_t residual =
            luma - block.predict(cell, std::countr_zero(octants), unused, unused)[0];
        if (octants == svo_.masks[node]) {
          first = luma;
          first_residual = residual;
        }
        without += std::abs(luma - first);
        with += std::abs(residual - first_residual);
      }
    }
  }
  return 20 * with < 19 * without;
}

Bytes TransformEncoder::encode_layer(const CoefficientSteps& steps) {
  const int first_level = layer_ == 0 ? 0 : layer_ends_[layer_ - 1];
  const bool predicts = layer_ == 0 || prediction_pays(first_level);
  Bytes out;
  ByteWriter writer(out);
  const int flags = (predicts ? kPredictionFlag : 0) | (exact_ ? kExactFlag : 0);
  writer.put(static_cast<std::uint8_t>(flags));
  writer.put(steps.luma);
  writer.put(steps.chroma);
  const SourceValues source{means_, leaves_};
  if (layer_ == 0 && svo_.node_count() > 0) {
    for (int k = 0; k < 3; ++k) writer.put(source.at(0)->lanes[k]);
    if (!decoded_.empty()) decoded_[0] = *source.at(0);
  }
  CoefficientWriter coder(out);
  LayerCoder<CoefficientWriter>(svo_, first_level, layer_ends_[layer_], steps,
                                predicts ? &neighborhoods_ : nullptr, contexts_, coder, &source,
                                decoded_.data(), exact_)
      .run();
  coder.finish();
  ++layer_;
  return out;
}

TransformDecoder::TransformDecoder(const Svo& svo)
    : svo_(svo),
      decoded_(std::make_unique_for_overwrite<Short4[]>(svo.node_count())),
      neighborhoods_(svo) {}

Result<void> TransformDecoder::decode_layer(ByteView bytes, int last_level, int stop) {
  ByteReader reader(bytes);
  const auto flags = reader.get<std::uint8_t>();
  CoefficientSteps steps;
  steps.luma = reader.get<std::uint16_t>();
  steps.chroma = reader.get<std::uint16_t>();
  if (level_ == 0 && svo_.node_count() > 0) {
    Int4 root = {};
    for (int k = 0; k < 3; ++k) root[k] = reader.get<std::int16_t>();
    decoded_[0] = stored_value(root + fourth_lane(0));
  }
  const bool exact = (flags & kExactFlag) != 0;
  if (level_ == 0) exact_ = exact;
  if (!reader.ok() || flags > (kPredictionFlag | kExactFlag) || exact != exact_ ||
      steps.luma == 0 || steps.chroma == 0) {
    return fail("a field is out of range");
  }
  CoefficientReader coder(reader.rest());
  Neighborhoods* neighborhoods = (flags & kPredictionFlag) != 0 ? &neighborhoods_ : nullptr;
  LayerCoder<CoefficientReader>(svo_, level_, last_level, steps, neighborhoods, contexts_, coder,
                                nullptr, decoded_.get(), exact)
      .run(stop);
  if (stop >= last_level && !coder.complete()) return fail("the bytes do not fit the tree");
  level_ = std::min(last_level, stop);
  return {};
}

void TransformDecoder::inherit(int last_level) {
  for (; level_ < last_level; ++level_) {
    const std::size_t l = static_cast<std::size_t>(level_);
    Short4* child = decoded_.get() + svo_.level_begin[l + 1];
    for (std::uint32_t node = svo_.level_begin[l]; node < svo_.level_begin[l + 1]; ++node) {
      for (int count = std::popcount(svo_.masks[node]); count > 0; --count) {
        *child++ = decoded_[node];
      }
    }
  }
}

std::span<const Short4> TransformDecoder::values(int level) const {
  return {decoded_.get() + svo_.level_begin[static_cast<std::size_t>(level)],
          svo_.node_count(level)};
}

std::span<const Short4> TransformDecoder::values() const {
  return {decoded_.get(), svo_.level_begin[static_cast<std::size_t>(level_) + 1]};
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

}  // namespace

CoefficientSteps color_steps(int quality) {
  const std::uint32_t luma = coefficient_step(quality);
  const std::uint32_t chroma = std::min(luma * 2, std::uint32_t{65535});
  return {static_cast<std::uint16_t>(luma), static_cast<std::uint16_t>(chroma)};
}

CoefficientSteps normal_steps(int quality) {
  const auto step = static_cast<std::uint16_t>(coefficient_step(quality));
  return {step, step};
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
