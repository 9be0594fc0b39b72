#pragma once

#include <memory>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "client/record/audio_feed.h"
#include "client/record/frame_rate.h"
#include "client/record/recorder.h"

namespace pointreel {

/// Fails with ErrorCode::argument if the name does not end in .png: pictures are written as PNG.
Result<void> check_picture_name(const std::string& path);
/// Fails with ErrorCode::argument if the path names neither a video (is_video) nor numbered
/// pictures (NumberedPath).
Result<void> check_recording_name(const std::string& path);
/// Checks the name, and for videos that ffmpeg is installed. Writes nothing.
Result<void> check_recording(const std::string& path);

/// Begins a recording of pictures of this size. Without a rate, each picture has a time of its own.
/// Videos get this sound, if there is one.
Result<std::unique_ptr<Recorder>> open_recorder(const std::string& path, glm::ivec2 size,
                                                const std::optional<FrameRate>& rate,
                                                std::optional<RecordedSound> sound = {});

}  // namespace pointreel
