#include "client/window/camera_recorder.h"

#include <fmt/format.h>

#include "client/record/numbered_path.h"
#include "client/ui/time_text.h"

namespace pointreel {

std::string CameraRecorder::add(const Camera& camera, std::uint64_t time_us) {
  if (file_.empty()) file_ = NumberedPath::parse("pointreel-camera-%04d.json")->first_free();
  path_.up = camera.up;
  path_.set(key_of(camera, time_us));
  if (const auto saved = save_camera_path(file_, path_); !saved) return saved.error().message;
  return fmt::format("camera key {} at {}: {}", path_.keys.size(), format_time(time_us), file_);
}

}  // namespace pointreel
