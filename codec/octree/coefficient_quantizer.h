#pragma once

#include <array>

#include "codec/octree/coefficient_coder.h"
#include "codec/octree/raht.h"

namespace pointreel {

/// Quantises the differences of a node to multiples of their steps. Weighs errors against the
/// number of bits that coefficients take, which the contexts tell: J. Ramkumar and M. Orchard's
/// rate-distortion optimised thresholding, applied greedily to each coefficient and then to the
/// whole node.
///
/// `values`: the values of the node's children minus the expected ones; they are overwritten. Fills
/// q with a triple for each pair. Returns false if all of them are zero; q is then unspecified.
bool quantize_node(const MergeOrder& order, const NodeScales& scales, std::array<Int4, 8>& values,
                   const CoefficientContexts& contexts, int gradient, int activity,
                   std::array<Triple, 7>& q);

}  // namespace pointreel
