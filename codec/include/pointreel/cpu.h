#pragma once

#include <cstdint>

namespace pointreel {

/// Instruction sets that Pointreel uses where the processor has them. They make it faster and never
/// change a result.
enum CpuFeature : std::uint32_t {
  kCpuBmi2 = 1u << 0,  ///< by the codec
  kCpuAvx2 = 1u << 1,  ///< by the surface of points
};

/// Restricts the codec to those features of the processor that are in the mask: ~0u, the default,
/// allows all of them, and 0 leaves the portable code. Meant for tests and benchmarks. Applies to
/// frames whose coding begins after the call; safe to call from any thread.
void set_cpu_feature_mask(std::uint32_t mask);

/// The features that the processor has and the mask allows.
std::uint32_t cpu_features();

}  // namespace pointreel
