#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "pointreel/geometry.h"

namespace pointreel {

/// A number of each point, such as its intensity, height, class or temperature.
struct ScalarField {
  std::string name;           ///< as `is_scalar_name` wants it; unique in its cloud
  std::vector<float> values;  ///< as many as points; NaN where the value is unknown

  bool operator==(const ScalarField&) const = default;  ///< false where values are NaN
};

/// The most scalar fields that a cloud may have, and the most bytes of a name.
inline constexpr std::size_t kMaxScalars = 8, kMaxScalarName = 64;

/// Whether a text may name a scalar field: UTF-8 of 1 to kMaxScalarName bytes, without control
/// characters and others that are invisible or change the direction of writing.
bool is_scalar_name(std::string_view name);

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
  std::vector<ScalarField> scalars;  ///< no more than kMaxScalars

  std::size_t size() const { return positions.size(); }
  bool empty() const { return positions.empty(); }
  bool has_normals() const { return !normals.empty(); }
  bool has_colors() const { return !colors.empty(); }
  bool has_radii() const { return !radii.empty(); }
  bool has_scalars() const { return !scalars.empty(); }

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
/// usable ones; if no radius is usable, removes the attribute. Sets infinite values of scalar
/// fields to NaN, and removes fields of which no value is known.
SanitizeReport sanitize(PointCloud& cloud);

}  // namespace pointreel
