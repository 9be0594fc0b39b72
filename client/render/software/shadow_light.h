#pragma once

#include <cstddef>

#include "client/render/shading.h"
#include "client/render/software/lane_vectors.h"
#include "client/render/software/shadow_map.h"

namespace pointreel {

/// For each lane, the float that comes so many places after the first.
POINTREEL_INLINE Lanes gather(const float* first, const LaneMask& places) {
  Lanes values{};
  for (std::size_t lane = 0; lane < kLanes; ++lane)
    values[lane] = first[static_cast<std::size_t>(places[lane])];
  return values;
}

/// `first`: a number of the first texel. Returns the means of that of four texels, by the shares of
/// those to the right of `texels` and above them.
POINTREEL_INLINE Lanes mean_at(const float* first, const LaneMask& texels, const Lanes& right,
                               const Lanes& above) {
  constexpr std::size_t kRight = 2, kAbove = 2 * kShadowEdge;
  const Lanes lower =
                  gather(first, texels) * (1.0f - right) + gather(first + kRight, texels) * right,
              upper = gather(first + kAbove, texels) * (1.0f - right) +
                      gather(first + kAbove + kRight, texels) * right;
  return lower * (1.0f - above) + upper * above;
}

/// The shares of the key light that reach points, given by their coordinates in the map. `apart`:
/// less than this in front of a point is no shadow. Light reaches all points outside of the map.
POINTREEL_INLINE Lanes light_reaching(const ShadowMap& shadow, const LaneVec& points, float apart) {
  constexpr float kEdge = kShadowEdge;
  const Lanes x = kEdge * points.x - 0.5f, y = kEdge * points.y - 0.5f;
  const LaneMask inside = (x >= 0.0f) & (y >= 0.0f) & (x < kEdge - 1.0f) & (y < kEdge - 1.0f);
  if (!any_lane(inside)) return Lanes{} + 1.0f;
  // Outside they may be too large for integers.
  const Lanes near_x = inside ? x : Lanes{}, near_y = inside ? y : Lanes{};
  const auto left = __builtin_convertvector(near_x, LaneMask),
             below = __builtin_convertvector(near_y, LaneMask);
  const LaneMask texel = 2 * (below * kShadowEdge + left);
  const float* const moments = shadow.moments().data();
  const Lanes right_share = near_x - __builtin_convertvector(left, Lanes),
              above_share = near_y - __builtin_convertvector(below, Lanes);
  const Lanes mean = mean_at(moments, texel, right_share, above_share),
              mean_square = mean_at(moments + 1, texel, right_share, above_share);
  // Where nothing is, the map has 0.
  const Lanes behind = mean - max_of(points.z, Lanes{}) - apart;
  const Lanes variance = max_of(mean_square - mean * mean, Lanes{} + 1e-6f);
  // The most that can be lit (Chebyshev). The last part of it is mostly light that leaks.
  const Lanes most = variance / (variance + behind * behind);
  const Lanes lit = (most - kLeak) / (1.0f - kLeak);
  return (inside & (behind > 0.0f)) ? max_of(min_of(lit, Lanes{} + 1.0f), Lanes{}) : Lanes{} + 1.0f;
}

}  // namespace pointreel
