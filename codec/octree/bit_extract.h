#pragma once

#include <cstdint>

/// Gathers the bits of a word that a mask selects, lowest first, as the instruction PEXT of BMI2
/// does. There are two forms with equal results; the one to use is chosen at run time.
namespace pointreel {

struct PortableExtract {
  static std::uint64_t extract(std::uint64_t word, std::uint64_t mask) {
    std::uint64_t bits = 0;
    for (std::uint64_t bit = 1; mask != 0; bit += bit) {
      const std::uint64_t lowest = mask & (~mask + 1);
      bits |= (word & lowest) != 0 ? bit : 0;
      mask ^= lowest;
    }
    return bits;
  }
};

#if defined(__x86_64__)
struct HardwareExtract {
  /// Written in assembly, so that code compiled for processors without the instruction can contain
  /// it.
  static std::uint64_t extract(std::uint64_t word, std::uint64_t mask) {
    std::uint64_t bits;
    __asm__("pextq %2, %1, %0" : "=r"(bits) : "r"(word), "rm"(mask));
    return bits;
  }
};
#endif

}  // namespace pointreel
