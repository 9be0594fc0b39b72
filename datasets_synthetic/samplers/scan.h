#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "datasets_synthetic/body.h"
#include "datasets_synthetic/samplers/scan_rig.h"
#include "pointreel/error.h"

namespace pointreel {

/// How the scanner measures. Lengths in metres; those of the pattern and of the pixels hold at the
/// working distance of the rig and grow in proportion to the distance, as a picture does. Shares
/// are of 1.
struct ScanOptions {
  RigOptions rig;

  /// Between neighbouring curves of one family of the pattern.
  double curve_spacing = 0.018;
  /// Between neighbouring rows and columns of a camera: a point where a curve crosses one.
  double pixel = 0.0025;
  /// The least cosine between the surface's normal and the way to the projector or the camera.
  double least_cosine = 0.2;

  /// Standard deviation of a point along the camera's ray, seen straight on; grows with the square
  /// of the distance and with 1 / cosine of the slant.
  double noise = 0.0003;
  /// Share of its variance that runs on along a curve, and how much of that one pixel passes to the
  /// next.
  double noise_correlated = 0.6;
  double noise_memory = 0.85;
  /// How far a pair's calibration is off, the same in every frame: standard deviations of a shift
  /// along each axis and of a turn about it, radians.
  double calibration_shift = 0.0012;
  double calibration_turn = 0.0004;
  /// Share of points that are wrong, and by how much at most, along the camera's ray; most are off
  /// by far less.
  double outliers = 0.002;
  double outlier_reach = 0.03;

  /// Curves are found in pieces of about this length; a share of them is lost at random, and of
  /// those on dark surfaces (darker than `dark` of white) another.
  double piece = 0.08;
  double lost = 0.06;
  double dark = 0.2;
  double lost_dark = 0.6;
  /// Patches that no camera sees well: how many, and the radius of the largest.
  int patches = 12;
  double patch_radius = 0.05;
};

/// One point that a pair has measured, and what it is a measurement of.
struct ScanPoint {
  glm::dvec3 position;  ///< as measured: with calibration, noise and outliers
  glm::dvec3 truth;     ///< on the surface, within 1e-7 m
  glm::dvec3 normal;    ///< of the surface there
  glm::u8vec3 color{0};
  std::uint16_t primitive = 0;
  std::uint16_t pair = 0;  ///< of make_rig
  std::uint16_t family =
      0;                   ///< 0: curves of constant x in the projector's picture, 1: of constant y
  std::int32_t curve = 0;  ///< number of the curve in its family
  bool outlier = false;
};

/// What cameras and projectors around the scene measure, as in paper 2, section III: each projector
/// throws a grid of curves, and each camera beside it gives the points where it sees a curve of
/// that projector cross one of its rows or columns. So points are dense along curves and sparse
/// across them, the spacing widens with the slant, and where several pairs see the same surface
/// they each give their own copy, slightly off. The points come curve by curve.
///
/// A function of surface, options, seed and frame alone: the same on every machine and whatever the
/// number of threads (TBB's, of the caller's arena). The seed decides the calibration too, the
/// frame does not. Fails for options that are out of range and where SurfaceGrid::build fails.
Result<std::vector<ScanPoint>> scan(const Body& body, const ScanOptions& options,
                                    std::uint64_t seed, int frame);

}  // namespace pointreel
