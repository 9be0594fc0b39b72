#include "codec/mesh/local_surface.h"

#include <cmath>
#include <limits>

namespace pointreel {
namespace {

/// The share of the best sphere's curvature that the surface has.
constexpr float kBeta = 0.8f;
/// The cosine of the largest angle between the normal of the nearest point and those that count.
constexpr float kLeastCosine = 0.3f;
/// The same for points that tell whether the surface goes on: also around edges and in folds.
constexpr float kLeastBesideCosine = -0.7f;
/// The distance of the mean of half a disc from its middle, with the weights of place_sums.h, as a
/// share of the radius.
constexpr float kHalfDisc = 0.2352f;
/// Random points are not spread evenly. Up to so many times the distance is no boundary.
constexpr float kUneven = 1.1f;
/// Within so many cells of a place, points do not count more in its colour the nearer they are.
constexpr float kColorSpot = 0.35f;

}  // namespace

void LocalSurface::move_to(const PointBlocks& blocks, std::uint32_t block) {
  points_.clear();
  reaches_.clear();
  numbers_.clear();
  const glm::dvec3 corner(blocks.corner(block));
  for (const KeyIndex& point : blocks.points(block)) {
    const glm::dvec3 place = of_.grid.inside(of_.cloud.positions[point.index]) - corner;
    points_.push_back({glm::vec3(place), of_.cloud.normals[point.index]});
    reaches_.push_back(of_.reaches[point.index]);
    numbers_.push_back(point.index);
  }
  while (all_.size() < points_.size()) all_.push_back(static_cast<std::uint32_t>(all_.size()));
}

NearestPoints LocalSurface::nearest(const Lanes& x, const Lanes& y, const Lanes& z) const {
  NearestPoints nearest;
  nearest.square = Lanes{} + std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const glm::vec3& p = points_[i].position;
    const Lanes dx = p.x - x, dy = p.y - y, dz = p.z - z;
    const Lanes square = dx * dx + dy * dy + dz * dz;
    const LaneMask nearer = square < nearest.square;
    nearest.square = nearer ? square : nearest.square;
    nearest.point = nearer ? LaneMask{} + static_cast<std::int32_t>(i) : nearest.point;
  }
  return nearest;
}

PlaceSums LocalSurface::sums(const Places& places) const {
  return sum_around(points_, std::span(all_).first(points_.size()), places);
}

SurfaceFits LocalSurface::fit(const Lanes& x, const Lanes& y, const Lanes& z,
                              const NearestPoints& nearest, const LaneMask& wanted) const {
  SurfaceFits fits;
  Places& places = fits.places;
  places.x = x;
  places.y = y;
  places.z = z;
  places.least_cosine = kLeastCosine;
  places.per_square = Lanes{} + 1.0f;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (!wanted[lane]) continue;
    const float radius = reach_of(nearest.point[lane]);
    places.per_square[lane] = 1.0f / (radius * radius);
    const glm::vec3& normal = normal_of(nearest.point[lane]);
    places.nx[lane] = normal.x;
    places.ny[lane] = normal.y;
    places.nz[lane] = normal.z;
  }
  const PlaceSums around = sums(places);
  fits.weight = around.w;
  fits.found = project_onto_spheres(around, kBeta, Lanes{}, Lanes{}, Lanes{});
  fits.found.found &= wanted;
  return fits;
}

void LocalSurface::measure_beside(SurfaceFits& fits) const {
  Places places = fits.places;
  places.least_cosine = kLeastBesideCosine;
  const PlaceSums around = sums(places);
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (!fits.found.found[lane]) continue;
    const glm::vec3 mean =
        glm::vec3(around.px[lane], around.py[lane], around.pz[lane]) / around.w[lane];
    const glm::vec3 normal(fits.found.nx[lane], fits.found.ny[lane], fits.found.nz[lane]);
    const float height = glm::dot(mean, normal);
    const float square = 1.0f / places.per_square[lane] - height * height;
    const float disc = std::sqrt(std::max(square, 0.01f));
    fits.beside[lane] = glm::length(mean - height * normal) / (kUneven * kHalfDisc * disc);
  }
}

glm::u16vec3 LocalSurface::color(const glm::vec3& place, const glm::vec3& normal) const {
  glm::vec3 sum(0.0f);
  float total = 0.0f;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const glm::vec3 way = points_[i].position - place;
    const float square = glm::dot(way, way) + kColorSpot * kColorSpot;
    if (!(glm::dot(points_[i].normal, normal) > 0.0f)) continue;
    // So steep that only the nearest points count, whatever their spacing.
    const float weight = 1.0f / (square * square * square);
    sum += weight * glm::vec3(of_.cloud.colors[numbers_[i]]);
    total += weight;
  }
  return total > 0.0f ? glm::u16vec3(sum / total + 0.5f) : glm::u16vec3(0);
}

}  // namespace pointreel
