#pragma once

#include <memory>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "client/record/frame_rate.h"
#include "client/record/recorder.h"

namespace pointreel {

/// Whether pictures can be recorded there: as a video (is_video), for which ffmpeg must be
/// installed, or to numbered files (NumberedPath). Nothing is written.
Result<void> check_recording(const std::string& path);

/// Begins to record pictures of this size, which come at this rate, or at times of their own.
Result<std::unique_ptr<Recorder>> open_recorder(const std::string& path, glm::ivec2 size,
                                                const std::optional<FrameRate>& rate);

}  // namespace pointreel
