#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace pointreel {

/// Eight numbers that are computed with at once. The compiler splits operations on them where the
/// processor has no vectors of this width, and the results are the same to the bit.
inline constexpr std::size_t kLanes = 8;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
/// All bits of a lane are set where a comparison holds, and none where it does not.
using LaneMask = std::int32_t __attribute__((vector_size(kLanes * sizeof(float))));

/// Each lane by its square root. Inlined, so that it is compiled for the processor of its caller.
[[gnu::always_inline]] inline void take_roots(Lanes& values) {
  for (std::size_t lane = 0; lane < kLanes; ++lane) values[lane] = std::sqrt(values[lane]);
}

}  // namespace pointreel
