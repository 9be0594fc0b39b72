#include "codec/core/lattice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace pointreel {
namespace {

constexpr std::array kSteps = {1e3, 500., 200., 100., 50., 20.,  10.,  5.,   2.,   1.,   .5,
                               .2,  .1,   .05,  .02,  .01, .005, .002, .001, 5e-4, 2e-4, 1e-4};

/// On a lattice whose step is fewer roundings of a float, almost any float would be near a point.
constexpr double kFinest = 64.0;

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

/// The step of a lattice on which many points may lie, by coordinates of some of them; 0 if it is
/// clear that there is none.
double likely_step(const PointCloud& cloud, double tolerance) {
  constexpr std::size_t kFewest = 1000, kLooked = 4096, kFewestGaps = 32;
  if (cloud.size() < kFewest) return 0.0;
  double likely = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> places;
    for (std::size_t i = 0; i < cloud.size(); i += 1 + cloud.size() / kLooked)
      places.push_back(cloud.world(i)[axis]);
    std::sort(places.begin(), places.end());
    double step = 0.0;
    std::size_t gaps = 0;
    for (std::size_t i = 1; i < places.size(); ++i) {
      const double gap = places[i] - places[i - 1];
      if (gap <= 4.0 * tolerance) continue;
      ++gaps;
      if (step == 0.0 || gap < step) step = gap;
    }
    if (gaps < kFewestGaps || tolerance > step / kFinest) continue;
    // The farther a place, the more precisely it tells the step.
    for (const double place : places) {
      const double away = place - places.front();
      if (const double steps = std::round(away / step); steps >= 1.0) step = away / steps;
    }
    if (likely == 0.0 || step < likely) likely = step;
  }
  return likely;
}

std::optional<PointLattice> on_lattice(const PointCloud& cloud, const Box& box, double step,
                                       double tolerance) {
  for (const glm::dvec3& point : {glm::dvec3(0.0), box.min}) {
    const PointLattice lattice{point, step};
    if (all_on(cloud, lattice, tolerance)) return lattice;
  }
  return std::nullopt;
}

}  // namespace

std::optional<PointLattice> lattice_of(const PointCloud& cloud) {
  if (cloud.empty()) return std::nullopt;
  const Box box = bounds(cloud);
  const double tolerance = rounding_of(cloud, box);
  // What lies on a lattice with another step, such as 0.0018, also lies on a finer one of these.
  if (const double likely = likely_step(cloud, tolerance); likely > 0.0) {
    const auto known = std::find_if(kSteps.begin(), kSteps.end(), [&](double step) {
      return std::abs(step - likely) < 1e-4 * step;
    });
    const double step = known == kSteps.end() ? likely : *known;
    if (const auto lattice = on_lattice(cloud, box, step, 4.0 * tolerance)) return lattice;
  }
  for (const double step : kSteps) {
    if (tolerance > step / kFinest) break;
    if (const auto lattice = on_lattice(cloud, box, step, tolerance)) return lattice;
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
