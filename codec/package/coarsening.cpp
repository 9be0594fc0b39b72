#include "codec/package/coarsening.h"

#include <algorithm>

namespace pointreel {
namespace {

/// As in OctreeOptions::color_quality, this much less quality doubles the error.
constexpr int kQualityPerDoubling = 14;

}  // namespace

int most_quality_lost(int levels) { return kQualityPerDoubling * (levels + 1); }

EncodeOptions coarsened(const EncodeOptions& options, int finest, const Coarsening& by) {
  EncodeOptions coarse = options;
  if (by.levels > 0) {
    coarse = no_deeper_than(options, std::max(kCoarsestDepth, finest - by.levels));
  }
  if (auto* octree = std::get_if<OctreeOptions>(&coarse.codec)) {
    octree->color_quality = std::max(1, octree->color_quality - by.quality);
    octree->normal_quality = std::max(1, octree->normal_quality - by.quality);
  } else {
    auto& draco = std::get<DracoOptions>(coarse.codec);
    draco.normal_bits =
        std::max(kMinNormalBits, draco.normal_bits - by.quality / kQualityPerDoubling);
  }
  return coarse;
}

EncodeOptions no_deeper_than(const EncodeOptions& options, int depth) {
  EncodeOptions bounded = options;
  if (auto* octree = std::get_if<OctreeOptions>(&bounded.codec)) {
    octree->depth.most = std::min(octree->depth.most, depth);
  } else {
    auto& draco = std::get<DracoOptions>(bounded.codec);
    draco.position_bits = std::min(draco.position_bits, depth);
  }
  return bounded;
}

}  // namespace pointreel
