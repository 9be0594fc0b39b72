#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "pointreel/geometry.h"

namespace pointreel {

/// One frame of points, as a structure of arrays. `positions` are relative to `origin`, so that
/// coordinates far from zero (maps, millimetres) keep their precision in float. Every other array
/// is either empty, when the source has no such attribute, or as long as `positions`: an absent
/// attribute is absent and nobody invents it silently.
struct PointCloud {
  glm::dvec3 origin{0.0};            ///< world coordinates of the local zero
  std::vector<glm::vec3> positions;  ///< local, finite
  std::vector<glm::vec3> normals;    ///< unit length, or zero where the point's normal is unknown
  std::vector<glm::u16vec3> colors;  ///< sRGB, 0 to 65535; an 8-bit value v is stored as 257 v
  std::vector<float> radii;          ///< splat radius > 0, in the units of the positions

  std::size_t size() const { return positions.size(); }
  bool empty() const { return positions.empty(); }
  bool has_normals() const { return !normals.empty(); }
  bool has_colors() const { return !colors.empty(); }
  bool has_radii() const { return !radii.empty(); }

  glm::dvec3 world(std::size_t i) const { return origin + glm::dvec3(positions[i]); }
};

/// World-space bounds of all points. O(n).
Box bounds(const PointCloud& cloud);

/// True if every colour is an 8-bit value times 257, so that 8 bits hold all there is.
bool colors_fit_8_bits(const PointCloud& cloud);

/// What `sanitize` found and mended.
struct SanitizeReport {
  std::size_t dropped_positions = 0;  ///< points with a NaN or infinite coordinate, removed
  std::size_t unknown_normals = 0;    ///< zero, NaN or infinite normals, set to zero
  std::size_t unknown_radii = 0;      ///< zero, negative, NaN or far too large radii, set to zero

  bool clean() const { return dropped_positions + unknown_normals + unknown_radii == 0; }
};

/// Makes a cloud that came from outside fit for use: drops points that have no finite position
/// (they must never reach a bounding box), normalises normals and zeroes those that have no
/// direction, and zeroes unusable radii, those beyond four times the 99th percentile of the others
/// included (`estimate_unknown_radii` takes them from the neighbours). If no radius is usable, the
/// attribute is removed.
SanitizeReport sanitize(PointCloud& cloud);

}  // namespace pointreel
