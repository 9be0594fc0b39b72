#pragma once

#include <filesystem>

#include <nlohmann/json.hpp>

#include "pointreel/error.h"

namespace pointreel::bench {

/// What `pointreel play` says of so many frames of soccer-shoot, made and packed as a user does and
/// drawn offscreen at 1280x720, in each mode: frames a second and the medians of every stage. Uses
/// a folder of its own in `folder`, and removes it.
Result<nlohmann::json> measure_playback(const std::filesystem::path& folder, int frames);

}  // namespace pointreel::bench
