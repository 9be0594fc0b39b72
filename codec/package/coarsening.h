#pragma once

#include "pointreel/draco.h"

/// How frames are encoded coarser than asked for, if the bit rate or the time does not suffice.
namespace pointreel {

/// Nothing is coarsened to a smaller depth.
inline constexpr int kCoarsestDepth = 1;

/// By how much frames are coarser than asked for.
struct Coarsening {
  int levels = 0;   ///< fewer levels of the octree, or of Draco's grid: each doubles the voxel size
  int quality = 0;  ///< lower quality of colours and normals: every 14 double their error

  bool operator==(const Coarsening&) const = default;
};

/// The most quality that attributes may lose together with this many levels. Geometry has priority,
/// but the error of attributes may grow by at most twice the factor by which the voxels grow: with
/// n levels less, attributes lose up to 14 (n + 1).
int most_quality_lost(int levels);

/// Coarser options. `finest` is the depth of the deepest frame that `options` would give. Draco's
/// normals lose one bit for every 14; its colours are always exact.
EncodeOptions coarsened(const EncodeOptions& options, int finest, const Coarsening& by);

/// The same options, but no frame is deeper than `depth`, which is kCoarsestDepth to kMaxDepth.
EncodeOptions no_deeper_than(const EncodeOptions& options, int depth);

}  // namespace pointreel
