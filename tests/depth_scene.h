#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include <glm/glm.hpp>

#include "codec/files/camera_intrinsics.h"
#include "codec/files/picture.h"
#include "pointreel/error.h"

/// A red ball that moves before a slanted wall, as a depth camera sees it: for tests and
/// benchmarks. Coordinates are the camera's: x to the right, y down, z ahead, in metres.
namespace pointreel::depth_scene {

inline constexpr std::uint32_t kWidth = 160, kHeight = 120;

/// A camera whose centre is not that of the picture, for pictures of `width` x width * 3 / 4.
CameraIntrinsics camera(std::uint32_t width = kWidth, double steps_per_meter = 1000.0);
/// The same as Open3D writes it, and with `depth_scale`.
std::string intrinsics(const CameraIntrinsics& camera);

/// What a pixel sees. Coordinates are those of CameraIntrinsics.
struct Seen {
  double depth = 0.0;
  glm::dvec3 normal{0.0};  ///< faces the camera
  bool ball = false;
};
Seen look(const CameraIntrinsics& camera, double u, double v, int frame);

/// Rounded to steps.
DepthPicture depth(const CameraIntrinsics& camera, int frame);
ColorPicture color(const CameraIntrinsics& camera, int frame);

/// The bytes of a PNG file.
std::string png(const DepthPicture& picture);
std::string png(const ColorPicture& picture);

/// Writes `depth/0.png`, `color/0.png`, and so on, and intrinsic.json.
void write(const std::filesystem::path& folder, int frames, const CameraIntrinsics& camera);

/// Makes a video of such a folder, with colours as cameras compress them, and its intrinsics beside
/// it. Errors: `not_found` without ffmpeg; what ffmpeg says.
Result<void> write_video(const std::filesystem::path& folder, const std::filesystem::path& video,
                         int fps);

}  // namespace pointreel::depth_scene
