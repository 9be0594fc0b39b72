#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>

#include "codec/octree/adaptive_bit.h"
#include "codec/octree/range_coder.h"

/// Quantised coefficients as binary decisions, written once for both directions: Coder is
/// CoefficientWriter or CoefficientReader. FORMAT.md, "Coefficients".
namespace pointreel {

/// Codes what it is given.
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

/// Gives what was coded, whatever it is given.
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

/// The quantised coefficients of one pair: luma, two chroma.
using Triple = std::array<std::int32_t, 3>;

inline bool is_zero(const Triple& q) { return (q[0] | q[1] | q[2]) == 0; }

/// What is learnt of a layer's coefficients.
struct CoefficientContexts {
  static constexpr int kActivities = 7, kGradients = 5;
  AdaptiveBit node[kGradients][kActivities][4];
  AdaptiveBit triple[kGradients][3][kActivities][3];
  AdaptiveBit component[3][3][kActivities];
  AdaptiveBit above_one[3][kActivities], above_two[3][kActivities];
  AdaptiveBit length[3][16], second_digit[3][17];
  AdaptiveBit sign[3][9][3];
};

/// What is known before a pair's triple is coded.
struct TripleContext {
  int gradient = 0, activity = 0;  ///< classes, of the node
  int place = 0;                   ///< 0 to 2: last pair, last but one, others
  int stage = 0;                   ///< 0 to 2: triples of the node that are not zero so far
  std::array<int, 3> expected{};   ///< by component: the sign of the expected difference; 2: minus
};

/// A magnitude of 1 or more.
template <class Coder>
std::int32_t code_magnitude(Coder& coder, CoefficientContexts& contexts, int component,
                            int activity, std::int32_t magnitude) {
  if (coder.code(contexts.above_one[component][activity], magnitude > 1) == 0) return 1;
  if (coder.code(contexts.above_two[component][activity], magnitude > 2) == 0) return 2;
  // Exponential Golomb: the number of binary digits of what is left, then all but the first.
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

/// A triple that may be zero only if `may_be_zero`.
template <class Coder>
void code_triple(Coder& coder, CoefficientContexts& contexts, const TripleContext& context,
                 bool may_be_zero, Triple& q) {
  if constexpr (!Coder::kEncodes) q = {};  // the coder ignores it, but it must be something
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
