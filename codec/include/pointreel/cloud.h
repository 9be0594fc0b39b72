#pragma once

#include <cstddef>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "pointreel/geometry.h"

namespace pointreel {

/// One frame of points, as a structure of arrays. `positions` are relative to `origin`, so that
/// coordinates far from zero (maps, millimetres) keep their precision in float. Each of the other
/// arrays is as long as `positions`, or empty if the source does not have the attribute: no
/// function fills in an attribute that is missing unless it says so.
struct PointCloud {
  glm::dvec3 origin{0.0};            ///< world coordinates of the local zero
  std::vector<glm::vec3> positions;  ///< local, finite
  std::vector<glm::vec3> normals;    ///< of unit length, or zero where the normal is unknown
  std::vector<glm::u16vec3> colors;  ///< sRGB, 0 to 65535; an 8-bit value v is stored as 257 v
  std::vector<float> radii;          ///< splat radius > 0, in the units of the positions

  std::size_t size() const { return positions.size(); }
  bool empty() const { return positions.empty(); }
  bool has_normals() const { return !normals.empty(); }
  bool has_colors() const { return !colors.empty(); }
  bool has_radii() const { return !radii.empty(); }

  /// World coordinates of point i.
  glm::dvec3 world(std::size_t i) const { return origin + glm::dvec3(positions[i]); }
};

/// The bounds of all points in world coordinates. O(n).
Box bounds(const PointCloud& cloud);

/// True if every colour is an 8-bit value times 257, so that 8 bits lose nothing.
bool colors_fit_8_bits(const PointCloud& cloud);

/// What `sanitize` found and repaired.
struct SanitizeReport {
  std::size_t dropped_positions = 0;  ///< points with a NaN or infinite coordinate, removed
  std::size_t unknown_normals = 0;    ///< zero, NaN or infinite normals, set to zero
  std::size_t unknown_radii = 0;      ///< zero, negative, NaN or far too large radii, set to zero

  bool clean() const { return dropped_positions + unknown_normals + unknown_radii == 0; }
};

/// Makes a cloud from an untrusted source safe to use. Removes points without a finite position,
/// which would spoil every bounding box. Normalises normals, and sets those without a direction to
/// zero. Sets unusable radii to zero, including those above four times the 99th percentile of the
/// usable ones; if no radius is usable, removes the attribute.
SanitizeReport sanitize(PointCloud& cloud);

}  // namespace pointreel
