#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>

#include "codec/octree/level_prediction.h"
#include "codec/octree/symbol_coder.h"

/// Codes quantised coefficients. The functions are written once for both directions: Coder is
/// SymbolEncoder or SymbolDecoder. FORMAT.md, "Coefficients".
namespace pointreel {

/// The quantised coefficients of a pair: luma and two chroma.
using Triple = std::array<std::int32_t, 3>;

inline bool is_zero(const Triple& q) { return (q[0] | q[1] | q[2]) == 0; }

/// Which coefficients of a triple are not zero, one bit for each.
inline unsigned pattern_of(const Triple& q) {
  return (q[0] != 0 ? 1u : 0u) | (q[1] != 0 ? 2u : 0u) | (q[2] != 0 ? 4u : 0u);
}

/// The adaptive alphabets of a frame's coefficients.
struct CoefficientContexts {
  static constexpr std::size_t kAround = kGradientClasses * kActivityClasses, kRecent = 3;

  /// The first symbol of nodes with one, two, three and more pairs. It is 0 if there are no
  /// coefficients.
  Alphabet8 first[4][kAround][kRecent];
  Alphabet8 pairs[kAround][3];                      ///< of nodes with four pairs or more
  Alphabet8 pattern[kActivityClasses][kRecent][2];  ///< of pairs in nodes with several
  Alphabet8 signs[8];                               ///< of colours, by pattern
  Alphabet8 magnitude[3][kActivityClasses][2], digits[3][kActivityClasses], leading[3][8];

  CoefficientContexts();
};

/// What is known before a node is coded.
struct NodeContext {
  std::size_t around = 0;    ///< gradient class * kActivityClasses + activity class
  std::size_t activity = 0;  ///< activity class
  std::size_t recent = 0;    ///< class of the nodes coded before it
};

/// How much there was to code in the last nodes.
class RecentActivity {
 public:
  std::size_t context() const { return (value_ >= 6 ? 1u : 0u) + (value_ >= 48 ? 1u : 0u); }
  void add(std::int32_t activity) { value_ += (std::min(4 * activity, 256) - value_) >> 2; }

 private:
  std::int32_t value_ = 0;
};

/// The alphabet of a node's first symbol.
inline Alphabet8& first_alphabet(CoefficientContexts& contexts, const NodeContext& context,
                                 int pairs) {
  const auto kind = static_cast<std::size_t>(std::min(pairs, 4) - 1);
  return contexts.first[kind][context.around][context.recent];
}
inline const Alphabet8& first_alphabet(const CoefficientContexts& contexts,
                                       const NodeContext& context, int pairs) {
  return first_alphabet(const_cast<CoefficientContexts&>(contexts), context, pairs);
}

/// Which pairs of a node have coefficients, one bit for each, the last pair first. `pattern`: that
/// of the only pair of a node with one; it is what is coded for it.
template <class Coder>
[[gnu::always_inline]] inline unsigned code_pairs(Coder& coder, CoefficientContexts& contexts,
                                                  const NodeContext& context, int pairs,
                                                  unsigned coded, unsigned& pattern) {
  // Most nodes have no coefficients. All of them go the same way, so that it is predicted.
  const unsigned symbol = pairs == 1 ? pattern : pairs > 3 ? (coded != 0 ? 1u : 0u) : coded;
  const auto first = static_cast<unsigned>(
      coder.code(0, first_alphabet(contexts, context, pairs), static_cast<int>(symbol)));
  if (first == 0) return 0;
  if (pairs == 1) {
    pattern = first;
    return 1;
  }
  if (pairs <= 3) return first & ((1u << pairs) - 1);
  unsigned known = 0;
  for (int done = 0; done < pairs; done += 3) {
    Alphabet8& alphabet = contexts.pairs[context.around][done == 0 ? 0 : known == 0 ? 1 : 2];
    known |= static_cast<unsigned>(coder.code(0, alphabet, static_cast<int>(coded >> done & 7)))
             << done;
  }
  return known & ((1u << pairs) - 1);
}

/// Magnitudes that have a symbol of their own.
inline constexpr std::int32_t kSmallMagnitudes = 7;

/// Codes the rest of a magnitude that has not, less kSmallMagnitudes: the number of its binary
/// digits, and all but the first of them, of which the highest three have a symbol.
template <class Coder>
[[gnu::noinline]] std::int32_t code_rest(Coder& coder, CoefficientContexts& contexts,
                                         std::size_t component, std::size_t activity,
                                         std::int32_t magnitude) {
  const auto rest = static_cast<std::uint32_t>(magnitude - kSmallMagnitudes);
  const int known = Coder::kEncodes ? static_cast<int>(std::bit_width(rest)) : 1;
  int digits = 1 + coder.code(1, contexts.digits[component][activity], std::min(known, 8) - 1);
  auto& alphabet = contexts.leading[component][digits - 1];
  if (digits == 8) digits += static_cast<int>(coder.bits(4, static_cast<std::uint32_t>(known - 8)));
  const int leading = std::min(digits - 1, 3), others = digits - 1 - leading;
  std::uint32_t value = 1u << leading;
  if (leading > 0) {
    const auto symbol = static_cast<int>((rest >> others) & (value - 1));
    value |= static_cast<std::uint32_t>(coder.code(1, alphabet, symbol)) & (value - 1);
  }
  value = value << others | coder.bits(others, rest & ((1u << others) - 1));
  return static_cast<std::int32_t>(value) + kSmallMagnitudes;
}

/// Codes a magnitude of 1 or more.
template <class Coder>
[[gnu::always_inline]] inline std::int32_t code_magnitude(Coder& coder,
                                                          CoefficientContexts& contexts,
                                                          std::size_t component,
                                                          std::size_t activity, bool several,
                                                          std::int32_t magnitude) {
  const int symbol = coder.code(1, contexts.magnitude[component][activity][several ? 1 : 0],
                                std::min(magnitude, kSmallMagnitudes + 1) - 1);
  if (__builtin_expect(symbol < kSmallMagnitudes, 1)) return symbol + 1;
  return code_rest(coder, contexts, component, activity, magnitude);
}

}  // namespace pointreel
