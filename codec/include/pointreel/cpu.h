#pragma once

#include <cstdint>

namespace pointreel {

/// Instruction sets that the codec uses where the processor has them. Results never depend on them.
enum CpuFeature : std::uint32_t {
  kCpuBmi2 = 1u << 0,
};

/// Uses only those features of the processor that the mask allows; ~0u, the default, allows all,
/// and 0 leaves the portable code. For tests and benchmarks. Takes effect in calls that begin
/// later; safe from any thread.
void set_cpu_feature_mask(std::uint32_t mask);

/// The features that the processor has and the mask allows.
std::uint32_t cpu_features();

}  // namespace pointreel
