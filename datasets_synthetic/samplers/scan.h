#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "datasets_synthetic/body.h"
#include "datasets_synthetic/samplers/scan_rig.h"
#include "pointreel/error.h"

namespace pointreel {

/// The properties of the scanner. Lengths are in metres. The lengths of the pattern and of the
/// pixels hold at the working distance of the rig and grow in proportion to the distance. Shares
/// are from 0 to 1.
struct ScanOptions {
  RigOptions rig;

  /// Distance between neighbouring curves of one family of the pattern.
  double curve_spacing = 0.018;
  /// Distance between neighbouring rows and columns of a camera. There is a point where a curve
  /// crosses a row or a column.
  double pixel = 0.0025;
  /// The least cosine between the surface normal and the direction to the projector or the camera.
  double least_cosine = 0.2;

  /// Standard deviation of a point along the camera's ray at perpendicular view. It grows with the
  /// square of the distance and with 1 / cosine of the slant.
  double noise = 0.0003;
  /// The share of this variance that is correlated along a curve, and the correlation from one
  /// pixel to the next.
  double noise_correlated = 0.6;
  double noise_memory = 0.85;
  /// The calibration error of a pair, the same in every frame: standard deviations of a shift along
  /// each axis and of a rotation about it, in radians.
  double calibration_shift = 0.0012;
  double calibration_turn = 0.0004;
  /// The share of outliers and their largest error along the camera's ray. Most outliers have a
  /// much smaller error.
  double outliers = 0.002;
  double outlier_reach = 0.03;

  /// Curves are detected in pieces of about this length. The share `lost` of the pieces is missing,
  /// and of the rest, the share `lost_dark` of what lies on surfaces darker than `dark` (1 is
  /// white).
  double piece = 0.08;
  double lost = 0.06;
  double dark = 0.2;
  double lost_dark = 0.6;
  /// The number of patches in which no camera finds points, and the radius of the largest.
  int patches = 12;
  double patch_radius = 0.05;
};

/// A point that a pair of camera and projector has measured, with the true point.
struct ScanPoint {
  glm::dvec3 position;  ///< as measured: with calibration error, noise and outliers
  glm::dvec3 truth;     ///< on the surface, within 1e-7 m
  glm::dvec3 normal;    ///< of the surface at `truth`
  glm::u8vec3 color{0};
  std::uint16_t primitive = 0;
  std::uint16_t pair = 0;  ///< index in Rig::pairs
  /// 0: curves of constant x in the projector's picture, 1: curves of constant y.
  std::uint16_t family = 0;
  std::int32_t curve = 0;  ///< number of the curve in its family
  bool outlier = false;
};

/// The points that cameras and projectors around the scene measure, as in Slomp et al., Geometry
/// Instancing, section III: each projector projects a grid of curves, and each neighbouring camera
/// measures the points where it sees one of these curves cross one of its rows or columns. So
/// points are dense along curves and sparse across them, the spacing widens with the slant, and
/// where several pairs see the same surface, each gives its own, slightly shifted copy. The points
/// come curve by curve.
///
/// The result depends on surface, options, seed and frame only: it is the same on every machine and
/// with any number of threads (TBB's, of the caller's arena). The calibration depends on the seed,
/// but not on the frame. Fails for options that are out of range, and where SurfaceGrid::build
/// fails.
Result<std::vector<ScanPoint>> scan(const Body& body, const ScanOptions& options,
                                    std::uint64_t seed, int frame);

}  // namespace pointreel
