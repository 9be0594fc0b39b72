#pragma once

#include <cstddef>
#include <cstdint>

namespace pointreel {

/// Eight numbers that are computed with at once. The compiler splits operations on them where the
/// processor has no vectors of this width, and the results are the same to the bit.
inline constexpr std::size_t kLanes = 8;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
/// All bits of a lane are set where a comparison holds, and none where it does not.
using LaneMask = std::int32_t __attribute__((vector_size(kLanes * sizeof(float))));

}  // namespace pointreel
