#pragma once

#include <cstdint>
#include <string>

#include "client/scene/camera.h"
#include "client/scene/camera_path.h"

namespace pointreel {

/// Keys of a path that `play --camera` follows, in a file of its own in the working folder. It is
/// written anew with each key, so that none is lost.
class CameraRecorder {
 public:
  /// What came of it, to be told: how many keys there are and where, or why they are not.
  std::string add(const Camera& camera, std::uint64_t time_us);

 private:
  CameraPath path_;
  std::string file_;  ///< empty before the first key
};

}  // namespace pointreel
