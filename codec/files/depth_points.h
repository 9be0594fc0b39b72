#pragma once

#include "codec/files/camera_intrinsics.h"
#include "codec/files/picture.h"
#include "pointreel/cloud.h"

namespace pointreel {

/// Values of depth that are no measurement: none, and further away than the numbers go.
inline constexpr std::uint16_t kNoDepth = 0, kTooFar = 65535;

/// Depth that jumps from a pixel to the next by more than this share belongs to two surfaces. At a
/// focal length of 500 pixels, it is a surface that the camera sees at 84 degrees.
inline constexpr float kDepthJump = 0.02f;

/// The points that a camera has measured, in metres as the camera sees them: x to the right, y up,
/// and the camera looks along -z. The order is that of the pixels, by rows.
///
/// Pixels that fly between two surfaces are left out: those whose depth jumps on both sides, in
/// their row or their column, where a neighbour that was not measured counts as a jump if the other
/// one jumps.
///
/// Normals are those of the plane through the 5 x 5 pixels around a point, without those beyond a
/// jump, and face the camera. Where too few are left for a plane, they point at the camera.
///
/// `camera` is that of `depth`, whatever size it says. `color`, if it is not null, lies over
/// `depth`, and may have another number of pixels.
PointCloud depth_points(const DepthPicture& depth, const CameraIntrinsics& camera,
                        const ColorPicture* color);

}  // namespace pointreel
