#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "client/scene/camera_path.h"
#include "tests/fuzz/target.h"

namespace pointreel::fuzz::camera_path {

bool between(double value, double a, double b) {
  const double slack = 1e-9 * std::max({1.0, std::abs(a), std::abs(b)});
  return value >= std::min(a, b) - slack && value <= std::max(a, b) + slack;
}

}  // namespace pointreel::fuzz::camera_path

/// An accepted path gives a camera at every time, which does not overshoot the values of the keys
/// around it. Writing and parsing the path again changes at most the last digits of angles.
FUZZ_TARGET(camera_path, .longest = 1 << 18, .repeats = true) {
  const auto path = parse_camera_path(as_text(input));
  if (!path) {
    if (path.error().message.empty()) std::abort();
    return;
  }
  const Camera framed;
  for (std::size_t i = 0; i < path->keys.size(); ++i) {
    const CameraKey& a = path->keys[i];
    const CameraKey& b = path->keys[std::min(i + 1, path->keys.size() - 1)];
    const std::uint64_t length = b.time_us - a.time_us;
    for (const std::uint64_t time : {a.time_us, a.time_us + length / 3, a.time_us + length / 2}) {
      const Camera camera = path->at(time, framed);
      const glm::dvec3 from = a.target.value_or(framed.target),
                       to = b.target.value_or(framed.target);
      for (int axis = 0; axis < 3; ++axis)
        if (!between(camera.target[axis], from[axis], to[axis])) std::abort();
      if (!between(camera.distance, a.distance.value_or(framed.distance),
                   b.distance.value_or(framed.distance)) ||
          !(camera.distance > 0.0) || !(std::abs(camera.yaw) <= 3.2) ||
          !(std::abs(camera.pitch) < 1.56) ||
          !between(camera.fov_y, a.fov_y.value_or(framed.fov_y), b.fov_y.value_or(framed.fov_y)))
        std::abort();
    }
  }
  const auto again = parse_camera_path(write_camera_path(*path));
  if (!again || again->up != path->up || again->keys.size() != path->keys.size()) std::abort();
  for (std::size_t i = 0; i < path->keys.size(); ++i) {
    const CameraKey &was = path->keys[i], &is = again->keys[i];
    if (is.time_us != was.time_us || is.target != was.target || is.distance != was.distance ||
        std::abs(is.yaw - was.yaw) > 1e-9 || std::abs(is.pitch - was.pitch) > 1e-9 ||
        is.fov_y.has_value() != was.fov_y.has_value())
      std::abort();
  }
}
