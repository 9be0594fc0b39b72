#pragma once

#include <cstdint>
#include <string_view>

#include "pointreel/error.h"

namespace pointreel {

/// A camera of depth without distortion: the pixel (u, v), counted from the centre of the one at
/// the top left, sees (u - cx) / fx to the right and (v - cy) / fy down at a distance of 1 ahead.
struct CameraIntrinsics {
  /// Of the pictures for which the other numbers hold; 0: of whatever picture there is.
  std::uint32_t width = 0, height = 0;
  double fx = 1.0, fy = 1.0, cx = 0.0, cy = 0.0;  ///< in pixels
  double steps_per_meter = 1000.0;                ///< of the numbers of depth, 1 to 10^6
  bool scale_is_given = false;                    ///< or steps_per_meter is the default
  bool distorts = false;  ///< the file has coefficients of distortion that are not 0
};

/// The longest text that is read, in bytes.
inline constexpr std::size_t kMaxIntrinsics = std::size_t{1} << 20;

/// Reads JSON with either `intrinsic_matrix`, as Open3D writes it (nine numbers by columns; by rows
/// is recognised, too; also as ROS's `K` and OpenCV's `camera_matrix`), or `fx` (or `fl_x`), `fy`
/// (`fl_y`), `cx` (`ppx`) and `cy` (`ppy`). `width` and `height` (`w` and `h`), and `depth_scale`
/// (`depth_factor`, `depth_units`, `depth_unit_scale_factor`) may be missing: steps per metre (1000
/// without it, 5000 in the TUM's data sets), or, below 1, metres per step, as RealSense has it.
/// Errors are `invalid` and name the member.
///
/// Trust: the text may be hostile (json_fields.h). All numbers are checked: focal lengths are 0.1
/// to 10^6, and the centre is no further than 10^6 from 0.
Result<CameraIntrinsics> parse_camera_intrinsics(std::string_view json);

}  // namespace pointreel
