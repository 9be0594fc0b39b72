#pragma once

#include <cstdint>
#include <string>

#include "client/scene/camera.h"
#include "client/scene/camera_path.h"

namespace pointreel {

/// Records a path for `play --camera`, key by key, in a new file in the current folder. The whole
/// file is written again with each key, so that none is lost.
class CameraRecorder {
 public:
  /// Adds a key and returns a message for the user: the number of keys and the file, or an error.
  std::string add(const Camera& camera, std::uint64_t time_us);

 private:
  CameraPath path_;
  std::string file_;  ///< empty before the first key
};

}  // namespace pointreel
