#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

/// Alphabets of 8 or 16 symbols whose frequencies are learned while they are coded. FORMAT.md,
/// "Alphabets".
///
/// An alphabet is the list of its cumulative frequencies, so that vectors find, split and adapt it
/// in a few instructions. The vector extensions of GCC and Clang work on all processors, and in
/// WebAssembly, and give the same everywhere.
namespace pointreel {

/// The frequencies of an alphabet's symbols sum to 2^kFrequencyBits.
inline constexpr int kFrequencyBits = 15;
inline constexpr std::int32_t kAllFrequencies = 1 << kFrequencyBits;
/// No frequency falls below this.
inline constexpr std::int32_t kLeastFrequency = 4;

namespace alphabet {

typedef std::int16_t Short8 __attribute__((vector_size(16)));

/// What the cumulative frequencies approach while a symbol is coded again and again.
template <int kSymbols>
struct Targets {
  alignas(16) std::int16_t of[kSymbols][kSymbols];

  Short8 vector(int symbol, int i) const {
    Short8 v;
    std::memcpy(&v, of[symbol] + 8 * i, sizeof(v));
    return v;
  }
};

template <int kSymbols>
inline constexpr Targets<kSymbols> kTargets = [] {
  Targets<kSymbols> all{};
  for (int symbol = 0; symbol < kSymbols; ++symbol) {
    for (int i = 0; i < kSymbols; ++i) {
      all.of[symbol][i] = static_cast<std::int16_t>(
          i <= symbol ? i * kLeastFrequency : kAllFrequencies - (kSymbols - i) * kLeastFrequency);
    }
  }
  return all;
}();

/// An alphabet counts the symbols that it has seen up to this.
inline constexpr int kMostSeen = 127;

/// After n symbols, the next one moves the frequencies by 1 / 2^kRates[n] of the way. Alphabets of
/// 8 symbols usually begin with nothing known, those of 16 with what was trained.
template <int kSymbols>
inline constexpr auto kRates = [] {
  std::array<std::uint8_t, kMostSeen + 1> rates{};
  for (int n = 0; n <= kMostSeen; ++n) {
    const int rate = kSymbols == 8 ? 1 + (n > 1) + (n > 4) + (n > 12) + (n > 32) + (n > 100)
                                   : 3 + (n > 4) + (n > 10) + (n > 24) + (n > 56) + (n > 120);
    rates[static_cast<std::size_t>(n)] = static_cast<std::uint8_t>(rate);
  }
  return rates;
}();

/// -log2 of (i + 1/2) / 2048, in 1/16, rounded to nearest.
inline constexpr auto kCosts = [] {
  std::array<std::uint8_t, 2048> costs{};
  for (std::uint32_t i = 0; i < 2048; ++i) {
    // Squaring yields one binary digit of the logarithm at a time, one more than is kept.
    std::uint64_t inverse = (std::uint64_t{4096} << 20) / (2 * i + 1);
    unsigned log = 0;
    for (int digit = 0; digit <= 5; ++digit) {
      if (digit > 0) {
        inverse = inverse * inverse >> 20;
        log *= 2;
      }
      for (; inverse >= std::uint64_t{2} << 20; inverse /= 2) ++log;
    }
    costs[i] = static_cast<std::uint8_t>((log + 1) / 2);
  }
  return costs;
}();

/// The lanes' low bytes.
inline std::uint64_t low_bytes(Short8 v) {
  typedef std::int8_t Byte8 __attribute__((vector_size(8)));
  typedef std::int8_t Byte16 __attribute__((vector_size(16)));
  const auto all = reinterpret_cast<Byte16>(v);
  const Byte8 narrow = __builtin_shufflevector(all, all, 0, 2, 4, 6, 8, 10, 12, 14);
  std::uint64_t bytes;
  std::memcpy(&bytes, &narrow, sizeof(bytes));
  return bytes;
}

}  // namespace alphabet

/// An interval of 2^kFrequencyBits numbers, which stand for a symbol.
struct SymbolRange {
  std::uint32_t begin, size;
};

template <int kSymbols>
class Alphabet {
  static_assert(kSymbols == 8 || kSymbols == 16);

 public:
  /// The first `used` symbols are equally frequent, and the others as rare as can be.
  explicit Alphabet(int used = kSymbols) {
    std::array<std::uint32_t, kSymbols> counts{};
    std::fill_n(counts.begin(), used, 1u);
    *this = Alphabet(counts, 0);
  }

  /// The frequencies are proportional to `counts`, whose sum is 1 to 2^31. `seen`: how many symbols
  /// they are worth, 0 to kMostSeen; it tells how fast they adapt.
  Alphabet(std::span<const std::uint32_t, kSymbols> counts, int seen) {
    std::uint64_t sum = 0;
    for (const std::uint32_t count : counts) sum += count;
    std::uint64_t before = 0;
    for (std::size_t i = 0; i < kSymbols; ++i) {
      constexpr std::uint64_t kShared = kAllFrequencies - kSymbols * kLeastFrequency;
      vectors_[i / 8][i % 8] =
          static_cast<std::int16_t>(i * kLeastFrequency + before * kShared / sum);
      before += counts[i];
    }
    set_seen(seen);
  }

  /// What stands for a symbol.
  SymbolRange range(int symbol) const {
    const std::int32_t begin = symbol == 0 ? 0 : lane(symbol);
    const std::int32_t end = symbol == kSymbols - 1 ? kAllFrequencies : lane(symbol + 1);
    return {static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end - begin)};
  }

  /// The symbol for which `number`, less than 2^kFrequencyBits, stands, and its range.
  int find(std::uint32_t number, SymbolRange& range) const {
    using namespace alphabet;
    const auto n = static_cast<std::int16_t>(number);
    const Short8 all = Short8{} + n;
    alignas(16) std::uint16_t sums[kSymbols + 8];
    const Short8 low = vectors_[0] & Short8{0, -1, -1, -1, -1, -1, -1, -1};
    std::memcpy(sums, &low, sizeof(low));
    sums[kSymbols] = kAllFrequencies;
    // The symbol is the last whose cumulative frequency is not larger than the number.
    int symbol;
    if constexpr (kSymbols == 8) {
      symbol = (63 - std::countl_zero(low_bytes(all > low - 1))) >> 3;
    } else {
      std::memcpy(sums + 8, &vectors_[1], sizeof(low));
      // Comparisons give -1; those of both halves are counted in one sum of bytes.
      const std::uint64_t larger = low_bytes(Short8{} - (low > all) - (vectors_[1] > all));
      symbol = 15 - static_cast<int>((larger * 0x0101010101010101) >> 56);
    }
    range.begin = sums[symbol];
    range.size = sums[symbol + 1] - range.begin;
    return symbol;
  }

  /// Learns that a symbol was coded.
  void update(int symbol) {
    using namespace alphabet;
    const int n = seen();
    const int rate = kRates<kSymbols>[static_cast<std::size_t>(n)];
    for (int i = 0; i < kSymbols / 8; ++i) {
      vectors_[i] += (kTargets<kSymbols>.vector(symbol, i) - vectors_[i]) >> rate;
    }
    set_seen(std::min(n + 1, kMostSeen));
  }

  /// The approximate cost of coding a symbol, in 1/16 of a bit.
  int cost(int symbol) const {
    return alphabet::kCosts[range(symbol).size >> (kFrequencyBits - 11)];
  }

  /// The number of symbols seen, at most kMostSeen.
  int seen() const { return vectors_[0][0]; }
  void set_seen(int seen) { vectors_[0][0] = static_cast<std::int16_t>(seen); }

 private:
  std::int32_t lane(int i) const { return vectors_[i / 8][i % 8]; }

  /// Lane i is the sum of the frequencies before symbol i. For symbol 0 this is 0, and the lane
  /// holds the number of symbols seen instead.
  alphabet::Short8 vectors_[kSymbols / 8];
};

using Alphabet8 = Alphabet<8>;
using Alphabet16 = Alphabet<16>;

}  // namespace pointreel
