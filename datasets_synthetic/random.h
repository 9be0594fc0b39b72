#pragma once

#include <cstdint>

namespace pointreel {

/// The finalizer of SplitMix64: spreads every bit of z over the whole number.
inline std::uint64_t mix_bits(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/// SplitMix64 (Steele, Lea, Flood: Fast Splittable Pseudorandom Number Generators, OOPSLA 2014).
/// Each pair of seed and stream gives its own sequence, so threads can share work by stream and the
/// numbers do not depend on how many threads there are. Unlike the distributions of the standard
/// library, it gives the same numbers on every machine.
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t stream)
      : state_(mix_bits(mix_bits(seed) + stream * 0x9e3779b97f4a7c15u)) {}

  std::uint64_t bits() {
    state_ += 0x9e3779b97f4a7c15u;
    return mix_bits(state_);
  }

  /// Uniform in [0, 1); a multiple of 2^-53.
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }

  /// Uniform in 0 .. count - 1; count > 0. The bias is below count / 2^32.
  std::uint32_t below(std::uint32_t count) {
    return static_cast<std::uint32_t>(((bits() >> 32) * count) >> 32);
  }

  /// Approximately normal with mean 0 and standard deviation 1. It is the sum of twelve uniform
  /// numbers: never beyond +-6, and without a logarithm whose last bit could differ between
  /// machines.
  double normal() {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }

 private:
  std::uint64_t state_;
};

}  // namespace pointreel
