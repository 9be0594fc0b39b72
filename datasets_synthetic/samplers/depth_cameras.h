#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "datasets_synthetic/body.h"
#include "datasets_synthetic/samplers/pinhole.h"
#include "pointreel/error.h"

namespace pointreel {

/// How far a badly calibrated camera is usually turned for each metre that it is shifted, in
/// radians: 0.2 degrees for 3 mm.
inline constexpr double kTurnPerShift = 1.1636;

/// The properties of a rig of cameras that each take a depth image and a colour image. Lengths are
/// in metres. Those marked * hold at the working distance of the rig. Shares are from 0 to 1.
struct DepthCameraOptions {
  int cameras = 8;          ///< 1 to 100, on a ring around the scene
  double radius = 2.2;      ///< of the ring
  double low = 0.5;         ///< height of every second camera
  double high = 1.7;        ///< height of the others
  double target = 0.9;      ///< height of the point that they look at
  double half_field = 0.8;  ///< tangent of half the field of view, horizontally and vertically
  double pixel = 0.008;     ///< * distance of neighbouring rays; at least 0.2 mm
  double baseline = 0.05;   ///< the colour camera is so far to the right of the depth camera

  /// * Standard deviation of a depth facing the surface. It grows with the square of the depth and
  /// with 1 / cosine of the slant.
  double noise = 0.003;
  /// The share of its variance that varies smoothly over the image, and the pixels over which it
  /// does so.
  double noise_smooth = 0.5;
  int grain = 4;
  /// * Step between the depths that can be measured, which are equal steps of disparity: it grows
  /// with the square of the depth.
  double depth_step = 0.002;
  /// The cosine between normal and ray below which a surface is too slanted to be measured: mean
  /// and standard deviation. The limit varies smoothly over the image and from frame to frame, so
  /// silhouettes are frayed.
  double least_cosine = 0.2, least_cosine_varies = 0.08;

  /// Of the pixels that see two surfaces, or a surface and the empty background, the share whose
  /// depth mixes both. The others are measured or lost like any other pixel. Pixels of a grain fly
  /// together.
  double flying = 0.4;
  /// How far behind the surface a pixel appears that sees almost nothing but background.
  double flying_reach = 0.25;

  /// The calibration error of a camera, the same in every frame: the root mean square of a shift
  /// and of a rotation, in radians, about the point that the cameras look at.
  double calibration_shift = 0.003;
  double calibration_turn = kTurnPerShift * calibration_shift;
  /// * The error of the colour image against the depth image, the same in every frame: standard
  /// deviation along each axis.
  double color_shift = 0.006;
};

/// A camera for depth and, looking the same way from beside it, one for colour.
struct DepthCamera {
  Pinhole depth, color;
};

/// A point that a camera has measured.
struct DepthPoint {
  glm::dvec3 position;  ///< as measured, with all errors
  glm::dvec3 normal;    ///< unit length, from the camera's own depth image, facing the camera
  /// The point of the surface on the ray of the pixel. For a flying pixel it has the depth of the
  /// nearest surface that the pixel sees, and need not lie on it.
  glm::dvec3 truth;
  glm::u8vec3 color{0};  ///< of what the colour camera sees at this place
  std::uint16_t camera = 0;
  std::uint16_t column = 0, row = 0;  ///< of the pixel, from the left and from the bottom
  bool flying = false;                ///< its depth mixes two surfaces, or one and the background
};

/// The mean distance in metres between the cameras and the point that they look at.
double working_distance(const DepthCameraOptions& options);

/// The cameras of the rig where they really are. The first looks at the front of the figure.
std::vector<DepthCamera> depth_camera_rig(const DepthCameraOptions& options);

/// What depth cameras around the scene measure: each gives a point for every pixel whose ray meets
/// the surface and that is not lost, camera by camera and row by row. Rays are the same in every
/// frame. Where several cameras see a surface, each samples it again, shifted by its calibration
/// error. The background is empty for the depth cameras; the colour cameras see a dark room with a
/// grey floor.
///
/// The result depends on surface, options, seed and frame only: it is the same on every machine and
/// with any number of threads (TBB's, of the caller's arena). Calibration and colour shift depend
/// on the seed, but not on the frame; all other errors depend on both. Fails for options that are
/// out of range, and where SurfaceGrid::build fails.
Result<std::vector<DepthPoint>> capture_depth(const Body& body, const DepthCameraOptions& options,
                                              std::uint64_t seed, int frame);

}  // namespace pointreel
