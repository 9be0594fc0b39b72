#pragma once

#include <filesystem>

#include <nlohmann/json.hpp>

#include "pointreel/codec.h"
#include "pointreel/error.h"

/// Groups of layered depth video that are kept in the repository: README.md. In their files, a
/// frame of the group takes the place of a layer.
namespace pointreel::golden {

/// For each frame up to the first that does not decode, the number of points and hashes of
/// positions, colours and normals, or the code of the error.
nlohmann::json video_outcome(const EncodedFrame& group);

/// Writes groups that today's encoder makes, damaged ones, and `outcomes.json` to the folder.
Result<void> write_videos(const std::filesystem::path& folder);

}  // namespace pointreel::golden
