#pragma once

#include <array>

#include "codec/octree/coefficient_coder.h"
#include "codec/octree/raht.h"

/// Quantises the differences of a node to multiples of their steps. Weighs errors against the
/// number of bits that coefficients take, which the contexts tell: J. Ramkumar and M. Orchard's
/// rate-distortion optimised thresholding, applied greedily to each coefficient and then to the
/// whole node.
namespace pointreel {

/// `differences`: those of the node's pairs, in the components that are coded. Fills q with a
/// triple for each pair. Returns false if all of them are zero; q is then unspecified.
bool quantize_node(int pairs, const NodeScales& scales, const PairSteps& steps,
                   const Int4* differences, const CoefficientContexts& contexts,
                   const NodeContext& context, std::array<Triple, 7>& q);

/// True if the differences of all pairs are so short that their components are quantised to zero in
/// any orthonormal frame.
/// The first step is the least.
bool are_short(int pairs, const NodeScales& scales, const PairSteps& steps,
               const Int4* differences);

}  // namespace pointreel
