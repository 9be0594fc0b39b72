#pragma once

#include "pointreel/codec.h"
#include "pointreel/draco.h"

/// What is taken away from what was asked for, where rate or time do not suffice.
namespace pointreel {

/// The least depth that anything is coarsened to.
inline constexpr int kCoarsestDepth = 1;

/// How much coarser than asked for.
struct Coarsening {
  int levels = 0;   ///< that octree, or Draco's grid, has fewer: each doubles the voxels
  int quality = 0;  ///< that colours and normals have less: 14 double their error

  bool operator==(const Coarsening&) const = default;
};

/// Geometry comes first, but attributes keep up with it: their error may grow by no more than twice
/// what the voxels grow by. So with n levels fewer, attributes lose up to 14 (n + 1).
int most_quality_lost(int levels);

/// The options made coarser. `finest` is the depth of the deepest frame that they would give.
/// Draco's normals lose a bit for 14; its colours are always exact.
EncodeOptions coarsened(const EncodeOptions& options, int finest, const Coarsening& by);

/// The options, but with frames of at most this depth, kCoarsestDepth to 21.
EncodeOptions no_deeper_than(const EncodeOptions& options, int depth);

}  // namespace pointreel
