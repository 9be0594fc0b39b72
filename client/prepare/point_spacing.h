#pragma once

#include <cstdint>
#include <span>

namespace pointreel {

/// The typical distance between neighbouring points of a surface, in the units of `edge`.
/// `occupied`: the number of occupied cells at each level of an octree whose cube has this edge,
/// down to a level at which hardly any cell holds more than a few points, or to the last. `points`:
/// how many points there are. 0 if the levels are all too coarse to tell, or there are fewer than
/// two points.
float point_spacing(std::span<const std::uint32_t> occupied, double edge, std::uint64_t points);

}  // namespace pointreel
