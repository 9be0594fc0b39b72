#include "codec/octree/coefficient_quantizer.h"

#include <bit>
#include <cstdint>
#include <cstdlib>

namespace pointreel {
namespace {

/// Fractions of a step are in units of 1/128, and numbers of bits in units of 1/16.
constexpr std::int32_t kStep = 128, kBit = 16;

/// A difference is rounded up to the next multiple of its step from a fraction of 1 - kRounding /
/// 128 on. This is more than a half, since smaller numbers take fewer bits.
constexpr std::int32_t kRounding = 56;

/// The squared error that a bit is worth, in 1/128 of a squared step, for a single coefficient of 1
/// and for all coefficients of a node. It is smaller for a node, because its descendants are
/// predicted from it.
constexpr std::int32_t kWorthOfOne = 14, kWorthOfNode = 14;

/// |difference| is less than 2^17.
std::int32_t steps_in(std::int32_t difference, std::int32_t step) {
  return static_cast<std::int32_t>(
      (std::uint64_t{static_cast<std::uint32_t>(std::abs(difference))} << 15) /
      static_cast<std::uint32_t>(step));
}

/// True if all components of a difference are less than 1 - kRounding / 128 of their steps.
bool rounds_to_zero(const Int4& difference, const Int4& step) {
  const Int4 above = (abs(difference) << 8) >= (step >> 7) * (kStep - kRounding);
  return (above[0] | above[1] | above[2]) == 0;
}

/// By how much the squared error grows if `x` steps are coded as 0 instead of q.
std::int64_t gain(std::int32_t x, std::int32_t q) {
  return std::int64_t{q} * (2 * std::int64_t{x} - std::int64_t{kStep} * q);
}

/// The number of bits that a magnitude and its sign take.
std::int32_t bits_of(const Alphabet8& alphabet, std::int32_t q) {
  if (q <= kSmallMagnitudes) return kBit + alphabet.cost(q - 1);
  const auto rest = static_cast<std::uint32_t>(q - kSmallMagnitudes);
  return kBit * 2 * std::bit_width(rest) + alphabet.cost(kSmallMagnitudes);
}

/// What it costs to say that a node has coefficients, and that it has none.
struct NodeCost {
  std::int32_t any, none;
};

NodeCost cost_of_node(int pairs, const CoefficientContexts& contexts, const NodeContext& context) {
  const Alphabet8& alphabet = first_alphabet(contexts, context, pairs);
  if (pairs == 1) return {0, alphabet.cost(0)};
  const std::int32_t none = alphabet.cost(0);
  const std::int32_t probable = static_cast<std::int32_t>(alphabet.range(0).size);
  // The rest of the range stands for all other symbols.
  return {alphabet::kCosts[static_cast<std::size_t>((kAllFrequencies - probable) >> 4)], none};
}

}  // namespace

bool quantize_node(int pairs, const NodeScales& scales, const PairSteps& steps,
                   const Int4* differences, const CoefficientContexts& contexts,
                   const NodeContext& context, std::array<Triple, 7>& q) {
  std::array<Triple, 7> fractions;
  std::int32_t any = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(pairs); ++i) {
    const Int4 step = steps(scales[i]);
    q[i] = {};
    if (rounds_to_zero(differences[i], step)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const int lane = static_cast<int>(k);
      fractions[i][k] = steps_in(differences[i][lane], step[lane]);
      q[i][k] = (fractions[i][k] + kRounding) / kStep;
      any |= q[i][k];
    }
  }
  if (any == 0) return false;

  any = 0;
  const NodeCost cost = cost_of_node(pairs, contexts, context);
  std::int32_t bits = cost.any - cost.none;
  std::int64_t gained = 0;
  const Alphabet8& patterns = pairs == 1 ? first_alphabet(contexts, context, pairs)
                                         : contexts.pattern[context.activity][context.recent][0];
  for (std::size_t i = 0; i < static_cast<std::size_t>(pairs); ++i) {
    Triple& triple = q[i];
    const Triple& x = fractions[i];
    const unsigned first_pattern = pattern_of(triple);
    const bool several = (first_pattern & (first_pattern - 1)) != 0;
    for (std::size_t k = 0; k < 3; ++k) {
      if (triple[k] == 0) continue;
      const Alphabet8& magnitudes = contexts.magnitude[k][context.activity][several ? 1 : 0];
      if (triple[k] == 1) {
        const unsigned pattern = pattern_of(triple);
        std::int32_t more = kBit + 10;
        if (pattern != 1u << k) {
          more = kBit + magnitudes.cost(0) + patterns.cost(static_cast<int>(pattern)) -
                 patterns.cost(static_cast<int>(pattern & ~(1u << k)));
        } else if (triple[k] == 1 && pairs == 1) {
          more = 0;  // weighed with the node
        }
        if (gain(x[k], 1) * kBit < std::int64_t{more} * kWorthOfOne) {
          triple[k] = 0;
          continue;
        }
      }
      gained += gain(x[k], triple[k]);
      bits += bits_of(magnitudes, triple[k]);
    }
    const unsigned pattern = pattern_of(triple);
    any |= static_cast<std::int32_t>(pattern);
    if (pairs == 1) {
      bits += patterns.cost(static_cast<int>(pattern));
    } else {
      bits += pattern == 0 ? kBit / 4 : kBit + patterns.cost(static_cast<int>(pattern));
    }
    for (std::size_t k = 0; k < 3; ++k) {
      if (differences[i][static_cast<int>(k)] < 0) triple[k] = -triple[k];
    }
  }
  return any != 0 && gained * kBit >= std::int64_t{bits} * kWorthOfNode;
}

bool are_short(int pairs, const NodeScales& scales, const PairSteps& steps,
               const Int4* differences) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(pairs); ++i) {
    typedef float Float4 __attribute__((vector_size(16)));
    const Float4 d = __builtin_convertvector(differences[i], Float4);
    const Float4 squares = d * d;
    // Two less, since a frame rounds.
    const float longest =
        static_cast<float>((steps(scales[i])[0] >> 7) * (kStep - kRounding)) / 256 - 2;
    if (squares[0] + squares[1] + squares[2] >= longest * longest) return false;
  }
  return true;
}

}  // namespace pointreel
