#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "codec/video/views.h"
#include "pointreel/cloud.h"

namespace pointreel {

/// The points of a frame, in pixels from the corner of its group's cube, sorted by cells of a few
/// pixels, and for each axis the points of each pixel of the views along it.
struct SurfacePoints {
  static constexpr int kCell = 8;  ///< pixels along each side of a cell

  /// The points of each pixel, in the order of their depth.
  struct Columns {
    std::vector<std::uint32_t> begin;   ///< of each pixel, row by row, and one more
    std::vector<std::uint32_t> points;  ///< their indices
    std::vector<std::uint32_t> used;    ///< the pixels that have points, in their order

    std::size_t first(std::size_t pixel) const { return begin[pixel]; }
    std::size_t end(std::size_t pixel) const { return begin[pixel + 1]; }
  };

  int side = 0;                           ///< pixels along each side of a view
  std::vector<glm::vec3> places;          ///< from 0 to `side`
  glm::ivec3 least{0}, most{0};           ///< the pixels of all places lie from here to there
  std::vector<glm::vec3> normals;         ///< of unit length or zero, as many
  std::vector<glm::u16vec3> colors;       ///< as many, or none
  std::vector<std::uint32_t> source;      ///< the index of each in the cloud
  std::vector<std::uint32_t> cell_begin;  ///< of the points of each cell that has any, and one more
  std::array<Columns, 3> columns;

  std::size_t size() const { return places.size(); }
  /// Of a point, from 0 to 255.
  glm::vec3 color(std::size_t point) const { return glm::vec3(colors[point]) / 257.0f; }
  std::size_t pixel_of(std::size_t point, const ViewAxes& axes) const {
    const glm::ivec3 cell(places[point]);
    return static_cast<std::size_t>(cell[axes.v]) * static_cast<std::size_t>(side) +
           static_cast<std::size_t>(cell[axes.u]);
  }
};

/// Of a cloud with normals, for views of `side` pixels of this edge. Points outside of the cube
/// move to its faces.
SurfacePoints surface_points(const PointCloud& cloud, const glm::dvec3& corner, double pitch,
                             int side);

}  // namespace pointreel
