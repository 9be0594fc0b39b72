#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "client/scene/camera.h"
#include "pointreel/error.h"

namespace pointreel {

/// Where the camera is at one time. Units are Camera's. Absent values are those with which the
/// scene is framed, so that a path of angles alone fits any scene.
struct CameraKey {
  std::uint64_t time_us = 0;         ///< of playback, from the reel's start on
  std::optional<glm::dvec3> target;  ///< each coordinate within +-1e12
  std::optional<double> distance;    ///< 1e-9 to 1e12
  double yaw = 0.0;                  ///< any number of turns within +-1e6 radians
  double pitch = 0.0;                ///< -pi/2 to pi/2
  std::optional<double> fov_y;       ///< 1 to 170 degrees

  bool operator==(const CameraKey&) const = default;
};

CameraKey key_of(const Camera& camera, std::uint64_t time_us);

/// A camera that moves smoothly through its keys, on a cubic between any two (Fritsch and Butland,
/// "A method for constructing local monotone piecewise cubic interpolants", 1984). It never
/// overshoots a key's value, stands still between keys that are alike, and turns at a constant rate
/// where the keys do. Distances are interpolated as logarithms, so that a zoom looks even. Yaw
/// takes the shorter way round. Before its first key and after its last it stands still.
struct CameraPath {
  std::optional<Up> up;         ///< that the angles refer to; absent: the scene's
  std::vector<CameraKey> keys;  ///< each later than the one before; `at` needs at least one

  /// Adds a key. It replaces a key at the same time.
  void set(const CameraKey& key);

  /// `framed`, moved to where the path is at this time.
  Camera at(std::uint64_t time_us, const Camera& framed) const;

  bool operator==(const CameraPath&) const = default;
};

inline constexpr std::size_t kMaxCameraKeys = 10'000;

/// As JSON; seconds and degrees:
///
///     {"pointreel_camera_path": 1, "up": "y", "keys": [
///       {"seconds": 0, "target": [0, 0.9, 0], "distance": 3, "yaw": 0, "pitch": 10, "fov": 40}]}
///
/// Only the version, the keys and each key's seconds must be there; yaw and pitch default to 0.
///
/// Trust: the text may be hostile. The result is within the bounds of CameraKey, and memory is
/// bounded by the text's length.
Result<CameraPath> parse_camera_path(std::string_view text);
/// One line for each key. Angles are rounded to 1e-9 degrees.
std::string write_camera_path(const CameraPath& path);

/// Reads a file of at most 4 MiB. Errors name the file.
Result<CameraPath> load_camera_path(const std::string& file);
/// Replaces the whole file or leaves it as it is.
Result<void> save_camera_path(const std::string& file, const CameraPath& path);

}  // namespace pointreel
