#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "codec/mesh/point_blocks.h"
#include "codec/surface/lanes.h"
#include "codec/surface/place_sums.h"
#include "codec/surface/point_rows.h"
#include "pointreel/cloud.h"

namespace pointreel {

/// A cloud with normals, and how far each point is seen. Lengths are in cells of the grid.
struct GriddedCloud {
  const PointCloud& cloud;
  MeshGrid grid;
  std::span<const float> reaches;
};

/// The points nearest to eight places.
struct alignas(sizeof(Lanes)) NearestPoints {
  Lanes square{};    ///< of the distance; infinite if there is no point
  LaneMask point{};  ///< numbers for LocalSurface::normal_of and the like
};

/// The surface at eight places.
struct alignas(sizeof(Lanes)) SurfaceFits {
  PlacesFound found;  ///< relative to the places
  Lanes weight{};     ///< the sum of the weights, each of which is at most 1
  Places places;      ///< with the normals of the nearest points
  /// How far the places are beside the middle of the points around them, compared with how far that
  /// is at the boundary of a surface: below 1 on the surface, above 1 beyond its boundary.
  Lanes beside{};
};

/// The surface around a block of the grid: the algebraic point set surface of point_surface.h, at
/// any place of the block. Of two sheets close together, the one with the nearest point counts. All
/// coordinates are relative to the block's corner.
class LocalSurface {
 public:
  explicit LocalSurface(const GriddedCloud& points) : of_(points) {}

  void move_to(const PointBlocks& blocks, std::uint32_t block);

  NearestPoints nearest(const Lanes& x, const Lanes& y, const Lanes& z) const;
  /// The surface near those places that are `wanted`.
  SurfaceFits fit(const Lanes& x, const Lanes& y, const Lanes& z, const NearestPoints& nearest,
                  const LaneMask& wanted) const;
  /// Fills in SurfaceFits::beside.
  void measure_beside(SurfaceFits& fits) const;
  /// The mean colour around a place, of points that face about the same way.
  glm::u16vec3 color(const glm::vec3& place, const glm::vec3& normal) const;

  float reach_of(std::int32_t point) const { return reaches_[static_cast<std::size_t>(point)]; }
  const glm::vec3& normal_of(std::int32_t point) const {
    return points_[static_cast<std::size_t>(point)].normal;
  }

 private:
  PlaceSums sums(const Places& places) const;

  GriddedCloud of_;
  std::vector<PointNormal> points_;
  std::vector<float> reaches_;
  std::vector<std::uint32_t> numbers_;  ///< in the cloud
  std::vector<std::uint32_t> all_;      ///< 0, 1, ...
};

}  // namespace pointreel
