#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "pointreel/error.h"

namespace pointreel::bench {

/// Plays a package offscreen at 1280x720. Returns frames per second and the medians of all stages
/// as `pointreel play` reports them.
Result<nlohmann::json> play_reel(const std::string& reel, const std::string& mode,
                                 const std::string& renderer);

/// Plays soccer-shoot with this many frames, made and packed as a user would do it, offscreen at
/// 1280x720 in each mode. Returns frames per second and the medians of all stages as `pointreel
/// play` reports them. Uses a temporary folder in `folder`.
Result<nlohmann::json> measure_playback(const std::filesystem::path& folder, int frames);

}  // namespace pointreel::bench
