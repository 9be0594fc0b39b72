#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "datasets_synthetic/sdf.h"
#include "pointreel/error.h"

namespace pointreel {

struct SurfacePoint {
  glm::dvec3 position;
  glm::dvec3 normal;  ///< unit length, outwards: the gradient of the distance
  std::uint16_t primitive = 0;
};

/// How far a sample may lie from the surface, in metres.
inline constexpr double kSurfaceTolerance = 1e-6;

/// `count` points, uniform by area and independent of each other. The points are a function of
/// surface, count and seed alone: the same on every machine and whatever the number of threads
/// (TBB's, of the caller's arena), and those of a smaller count begin those of a larger one.
/// Fails if the surface is empty or not finite, or too large or too small for a figure (a grid of
/// 11 mm divides it).
Result<std::vector<SurfacePoint>> sample_uniform(const Surface& surface, std::size_t count,
                                                 std::uint64_t seed);

}  // namespace pointreel
