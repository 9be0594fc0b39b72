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

/// `count` points, uniform by area and independent of each other. They depend on surface, count and
/// seed only: they are the same on every machine and with any number of threads (TBB's, of the
/// caller's arena), and a smaller count gives the first points of a larger one. Fails where
/// SurfaceGrid::build fails, and for a surface with almost no area.
Result<std::vector<SurfacePoint>> sample_uniform(const Surface& surface, std::size_t count,
                                                 std::uint64_t seed);

}  // namespace pointreel
