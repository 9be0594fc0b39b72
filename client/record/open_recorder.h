#pragma once

#include <memory>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "client/record/frame_rate.h"
#include "client/record/recorder.h"

namespace pointreel {

/// Whether that names a video (is_video) or numbered files (NumberedPath).
Result<void> check_recording_name(const std::string& path);
/// Whether pictures can be recorded there: for videos ffmpeg must be installed. Nothing is written.
Result<void> check_recording(const std::string& path);

/// Begins to record pictures of this size, which come at this rate, or at times of their own.
Result<std::unique_ptr<Recorder>> open_recorder(const std::string& path, glm::ivec2 size,
                                                const std::optional<FrameRate>& rate);

}  // namespace pointreel
