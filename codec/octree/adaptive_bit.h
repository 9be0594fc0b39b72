#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "codec/octree/range_coder.h"

/// Binary decisions whose probability is learned while they are coded. FORMAT.md, "Adaptive bits".
namespace pointreel {

namespace adaptive_bit {

/// -log2 of (i + 1/2) / 256, in 1/16, rounded to nearest.
inline constexpr auto kCosts = [] {
  std::array<std::uint8_t, 256> costs{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    // Squaring yields one binary digit of the logarithm at a time, one more than is kept.
    std::uint64_t inverse = (std::uint64_t{512} << 20) / (2 * i + 1);
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

}  // namespace adaptive_bit

/// A probability that is the mean of two estimates, which follow about the last 8 and the last 128
/// decisions. It is nearly as good as the better of the two. The first decisions count more. The
/// probability is never 0 or 1, but between 67 and 65468 of 65536.
class AdaptiveBit {
 public:
  /// The probability that the next decision is 1, out of 65536.
  std::uint32_t probability() const { return (std::uint32_t{fast_} + slow_) >> 1; }

  /// The approximate cost of coding a decision, in 1/16 of a bit.
  std::int32_t cost(unsigned bit) const {
    return adaptive_bit::kCosts[(probability() ^ ((bit - 1u) & 0xffffu)) >> 8];
  }

  void update(unsigned bit) {
    if (__builtin_expect(seen_ == kEnough, 1)) {
      follow(bit, 3, 7);
    } else {
      ++seen_;
      const int digits = std::bit_width(unsigned{seen_});
      follow(bit, std::min(digits, 3), digits);
    }
  }

 private:
  static constexpr std::uint16_t kEnough = 127;

  void follow(unsigned bit, int fast_shift, int slow_shift) {
    // Written for a decision of 0, and mirrored for a decision of 1.
    const unsigned mirror = (0u - bit) & 0xffffu;
    const unsigned fast = fast_ ^ mirror, slow = slow_ ^ mirror;
    fast_ = static_cast<std::uint16_t>((fast - (fast >> fast_shift)) ^ mirror);
    slow_ = static_cast<std::uint16_t>((slow - (slow >> slow_shift)) ^ mirror);
  }

  std::uint16_t fast_ = 0x8000, slow_ = 0x8000;
  std::uint16_t seen_ = 0;  ///< number of decisions, at most kEnough
};

}  // namespace pointreel
