#include "codec/core/lattice.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pointreel {
namespace {

constexpr std::array kSteps = {1e3, 500., 200., 100., 50., 20.,  10.,  5.,   2.,   1.,   .5,
                               .2,  .1,   .05,  .02,  .01, .005, .002, .001, 5e-4, 2e-4, 1e-4};

/// Whether the offset is a multiple of the step on each axis, up to a tolerance.
bool is_multiple(const glm::dvec3& offset, double step, double tolerance) {
  const glm::dvec3 off = glm::abs(offset - step * glm::round(offset / step));
  return std::max({off.x, off.y, off.z}) <= tolerance;
}

bool all_on(const PointCloud& cloud, const PointLattice& lattice, double tolerance) {
  const glm::dvec3 corner = cloud.origin - lattice.point;
  return std::all_of(cloud.positions.begin(), cloud.positions.end(), [&](const glm::vec3& p) {
    return is_multiple(corner + glm::dvec3(p), lattice.step, tolerance);
  });
}

/// How far the rounding of a cloud's floats may move a point off its lattice.
double rounding_of(const PointCloud& cloud, const Box& box) {
  const glm::dvec3 local =
      glm::max(glm::abs(box.min - cloud.origin), glm::abs(box.max - cloud.origin));
  const glm::dvec3 world = glm::max(glm::abs(box.min), glm::abs(box.max));
  return std::ldexp(std::max({local.x, local.y, local.z}), -23) +
         std::ldexp(std::max({world.x, world.y, world.z}), -50);
}

}  // namespace

std::optional<PointLattice> lattice_of(const PointCloud& cloud) {
  if (cloud.empty()) return std::nullopt;
  const Box box = bounds(cloud);
  const double tolerance = rounding_of(cloud, box);
  for (const double step : kSteps) {
    // On a lattice this fine, almost any float would be near one of the points.
    if (tolerance > step / 64.0) break;
    for (const glm::dvec3& point : {glm::dvec3(0.0), box.min}) {
      const PointLattice lattice{point, step};
      if (all_on(cloud, lattice, tolerance)) return lattice;
    }
  }
  return std::nullopt;
}

std::optional<PointLattice> common_lattice(const PointLattice& a, const PointLattice& b) {
  const PointLattice& fine = a.step <= b.step ? a : b;
  const double ratio = std::max(a.step, b.step) / fine.step;
  const double tolerance = fine.step / 64.0;
  if (std::abs(ratio - std::round(ratio)) > 1e-6) return std::nullopt;
  if (!is_multiple(a.point - b.point, fine.step, tolerance)) return std::nullopt;
  return fine;
}

VoxelCube lattice_cube(const Box& box, const PointLattice& lattice) {
  if (box.empty()) return voxel_cube(box, lattice.step);
  VoxelCube voxels = voxel_cube({box.min - lattice.point, box.max - lattice.point}, lattice.step);
  voxels.cube.origin += lattice.point;
  return voxels;
}

}  // namespace pointreel
