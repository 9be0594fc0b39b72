#pragma once

#include <array>

#include "codec/octree/coefficient_coder.h"
#include "codec/octree/raht.h"

namespace pointreel {

/// What the encoder makes of the differences of one node: multiples of their steps, weighing errors
/// against bits, of which the contexts tell how many a coefficient takes (J. Ramkumar and M.
/// Orchard's rate-distortion optimised thresholding, greedy: a coefficient, then the whole node).
///
/// `values`: of the node's children, less what is expected of them; of no use afterwards. Fills q,
/// one triple for each pair, or leaves it and returns false if all of it is zero.
bool quantize_node(const MergeOrder& order, const NodeScales& scales, std::array<Int4, 8>& values,
                   const CoefficientContexts& contexts, int gradient, int activity,
                   std::array<Triple, 7>& q);

}  // namespace pointreel
