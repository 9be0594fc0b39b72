#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>

#include "codec/octree/adaptive_bit.h"
#include "codec/octree/range_coder.h"

/// Codes quantised coefficients as binary decisions. The functions are written once for both
/// directions: Coder is CoefficientWriter or CoefficientReader. FORMAT.md, "Coefficients".
namespace pointreel {

/// Encodes the bits that it is given.
class CoefficientWriter {
 public:
  static constexpr bool kEncodes = true;
  explicit CoefficientWriter(Bytes& out) : range_(out) {}

  unsigned code(AdaptiveBit& context, unsigned bit) {
    range_.encode(bit, context.probability());
    context.update(bit);
    return bit;
  }
  unsigned code_even(unsigned bit) {
    range_.encode(bit, 0x8000);
    return bit;
  }
  void finish() { range_.finish(); }

 private:
  RangeEncoder range_;
};

/// Returns decoded bits, and ignores those that it is given.
class CoefficientReader {
 public:
  static constexpr bool kEncodes = false;
  explicit CoefficientReader(ByteView bytes) : range_(bytes) {}

  unsigned code(AdaptiveBit& context, unsigned) {
    const unsigned bit = range_.decode(context.probability());
    context.update(bit);
    return bit;
  }
  unsigned code_even(unsigned) { return range_.decode(0x8000); }
  bool complete() const { return range_.complete(); }

 private:
  RangeDecoder range_;
};

/// The quantised coefficients of a pair: luma and two chroma.
using Triple = std::array<std::int32_t, 3>;

inline bool is_zero(const Triple& q) { return (q[0] | q[1] | q[2]) == 0; }

/// The adaptive probabilities of a frame's coefficients.
struct CoefficientContexts {
  static constexpr int kActivities = 7, kGradients = 5;
  AdaptiveBit node[kGradients][kActivities][4];
  AdaptiveBit triple[kGradients][3][kActivities][3];
  AdaptiveBit component[3][3][kActivities];
  AdaptiveBit above_one[3][kActivities], above_two[3][kActivities];
  AdaptiveBit length[3][16], second_digit[3][17];
  AdaptiveBit sign[3][9][3];
};

/// What is known before the triple of a pair is coded.
struct TripleContext {
  int gradient = 0, activity = 0;  ///< the node's classes
  int place = 0;                   ///< 0 for the last pair, 1 for the last but one, 2 for others
  int stage = 0;                   ///< the number of the node's nonzero triples so far, at most 2
  /// For each component, the sign of the expected difference: 0 none, 1 plus, 2 minus.
  std::array<int, 3> expected{};
};

/// Codes a magnitude of 1 or more.
template <class Coder>
std::int32_t code_magnitude(Coder& coder, CoefficientContexts& contexts, int component,
                            int activity, std::int32_t magnitude) {
  if (coder.code(contexts.above_one[component][activity], magnitude > 1) == 0) return 1;
  if (coder.code(contexts.above_two[component][activity], magnitude > 2) == 0) return 2;
  // The rest is an exponential Golomb code: the number of binary digits, then all but the first.
  const auto rest = static_cast<std::uint32_t>(magnitude - 2);
  int digits = Coder::kEncodes ? static_cast<int>(std::bit_width(rest)) : 16;
  for (int i = 1;; ++i) {
    if (i == 16 || coder.code(contexts.length[component][i], i < digits) == 0) {
      digits = i;
      break;
    }
  }
  std::uint32_t decoded = 1;
  if (digits > 1) {
    decoded = 2 | coder.code(contexts.second_digit[component][digits], rest >> (digits - 2) & 1);
  }
  for (int digit = digits - 3; digit >= 0; --digit) {
    decoded = decoded << 1 | coder.code_even(rest >> digit & 1);
  }
  return static_cast<std::int32_t>(decoded) + 2;
}

/// Codes a triple, which is not zero unless `may_be_zero`.
template <class Coder>
void code_triple(Coder& coder, CoefficientContexts& contexts, const TripleContext& context,
                 bool may_be_zero, Triple& q) {
  if constexpr (!Coder::kEncodes) q = {};  // ignored by the reader, but must be initialised
  const int activity = context.activity;
  AdaptiveBit& any = contexts.triple[context.gradient][context.stage][activity][context.place];
  if (may_be_zero && coder.code(any, !is_zero(q)) == 0) {
    q = {};
    return;
  }
  int before = 0;
  int signs = 4;
  for (int k = 0; k < 3; ++k) {
    const auto c = static_cast<std::size_t>(k);
    const bool certain = k == 2 && before == 0;
    if (!certain && coder.code(contexts.component[k][before][activity], q[c] != 0) == 0) {
      q[c] = 0;
      continue;
    }
    const std::int32_t magnitude = code_magnitude(coder, contexts, k, activity, std::abs(q[c]));
    const bool negative = coder.code(contexts.sign[k][signs][context.expected[c]], q[c] < 0) != 0;
    q[c] = negative ? -magnitude : magnitude;
    ++before;
    if (k == 0) signs += negative ? 3 : -3;
    if (k == 1) signs += negative ? 1 : -1;
  }
}

}  // namespace pointreel
