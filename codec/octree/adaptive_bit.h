#pragma once

#include <cstdint>

#include "codec/octree/range_coder.h"

/// Binary decisions whose probability is learnt while they are coded. FORMAT.md, "Adaptive bits".
namespace pointreel {

/// The mean of two estimates, one that follows the last 16 or so decisions and one that remembers
/// some 128: nearly the better of both, without counting. Never certain: 71 to 65464 of 65536.
class AdaptiveBit {
 public:
  /// That the next decision is one, out of 65536.
  std::uint32_t probability() const { return (std::uint32_t{fast_} + slow_) >> 1; }

  void update(unsigned bit) {
    // As if the decision were zero, mirrored if it is one.
    const unsigned mirror = (0u - bit) & 0xffffu;
    const unsigned fast = fast_ ^ mirror, slow = slow_ ^ mirror;
    fast_ = static_cast<std::uint16_t>((fast - (fast >> 4)) ^ mirror);
    slow_ = static_cast<std::uint16_t>((slow - (slow >> 7)) ^ mirror);
  }

 private:
  std::uint16_t fast_ = 0x8000, slow_ = 0x8000;
};

}  // namespace pointreel
